#include <fstream>
#include <iomanip>
#include <sstream>

#include "io/atomic_file.h"
#include "pipelines/result_file.h"
#include "pipelines/spectrum_file.h"
#include "pipelines/version.h"

namespace micro {
namespace {

std::string number(const std::optional<double>& value) {
  if (!value) return "–";
  std::ostringstream text;
  text << std::setprecision(4) << *value;
  return text.str();
}

void add_scans(std::ostringstream& text, const NdfResult& result) {
  text << "## Scans\n\n"
       << "| scan | format | rows × cols | pitch, µm | missing | Sq, µm | Sdq "
          "|\n|---|---|---|---|---|---|---|\n";
  for (const ScanRecord& scan : result.scans)
    if (!scan.failure)
      text << "| " << scan.source << " | " << scan.format << " | " << scan.rows << " × " << scan.cols << " | "
           << number(scan.dx) << " × " << number(scan.dy) << " | " << scan.missing << " | " << number(scan.Sq)
           << " | " << number(scan.Sdq) << " |\n";
  text << "\nSq and Sdq after levelling.\n";
  bool failures = false;
  for (const ScanRecord& scan : result.scans) {
    if (!scan.failure) continue;
    if (!failures) text << "\n## Failed\n\n";
    failures = true;
    text << "- " << scan.source << ": " << *scan.failure << "\n";
  }
}

void add_ndfs(std::ostringstream& text, const NdfResult& result) {
  text << "\n## Normal distributions\n\n"
       << "| method | estimator | scans | extent | ∫D m_z dω | relative error | seconds "
          "|\n|---|---|---|---|---|---|---|\n";
  for (const NdfOfScans& ndf : result.ndfs)
    text << "| " << ndf.method.name << " | " << ndf.estimator << " | " << ndf.scans << " | "
         << number(ndf.density.grid.extent) << " | " << number(normalization(ndf.density)) << " | "
         << number(ndf.rel_error) << " | " << number(ndf.seconds) << " |\n";
  if (result.spectrum) {
    const SpectrumOfScans& spectrum = *result.spectrum;
    const SpectrumNumbers numbers = numbers_of(spectrum);
    text << "| kirchhoff_spectrum (" << spectrum.lambda_q.size() << " wavelengths, "
         << number(spectrum.lambda_q.front()) << " to " << number(spectrum.lambda_q.back())
         << " µm) | spectral | " << spectrum.mean.count() << " | " << number(spectrum.mean.grid().extent)
         << " | " << number(numbers.normalization) << " | " << number(numbers.rel_error) << " | "
         << number(spectrum.seconds) << " |\n";
  }
  if (result.directions)
    text << "| " << kDirectionsName << " (" << result.directions->h.size() << ") | "
         << result.directions->estimator << " | " << result.directions->scans << " | – | – | "
         << number(result.directions->rel_error) << " | " << number(result.directions->seconds) << " |\n";
}

void add_fits(std::ostringstream& text, const NdfFits& fits) {
  text << "\n## Fits\n\n"
       << "| method | model | alpha_x | alpha_y | theta_x | theta_y | theta_z | relative rms | status "
          "|\n|---|---|---|---|---|---|---|---|---|\n";
  for (const NdfFit& ndf_fit : fits.fits) {
    const EllipsoidParameters& p = ndf_fit.fit.parameters;
    text << "| " << ndf_fit.method << " | " << name_of(ndf_fit.fit.model) << " | " << number(p.alpha_x)
         << " | " << number(p.alpha_y) << " | " << number(p.theta_x) << " | " << number(p.theta_y) << " | "
         << number(p.theta_z) << " | " << number(ndf_fit.fit.rel_rms) << " | " << name_of(ndf_fit.fit.status)
         << " |\n";
  }
  text << "\nAngles in radians [Dong15 Eq. 12].\n";
}

}  // namespace

void write_report(const std::filesystem::path& path, const NdfResult& result, const ScanListing& listing,
                  const std::string& command) {
  std::ostringstream text;
  text << "# microbrdf " << version() << "\n\n`" << command << "`\n\n";
  add_scans(text, result);
  if (!listing.skipped.empty()) {
    text << "\n## Skipped\n\n";
    for (const Skipped& skipped : listing.skipped)
      text << "- " << skipped.source << ": " << skipped.reason << "\n";
  }
  add_ndfs(text, result);
  if (result.fits && !result.fits->fits.empty()) add_fits(text, *result.fits);
  text << "\n## Plan\n\n" << to_text(result.plan);
  const std::string bytes = text.str();
  write_file(path, std::as_bytes(std::span(bytes)));
}

}  // namespace micro
