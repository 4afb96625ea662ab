#include "pipelines/fits_of_result.h"

namespace micro {

std::vector<NdfTable> tables_of(const NdfResult& result) {
  std::vector<NdfTable> tables;
  for (const NdfOfScans& ndf : result.ndfs)
    tables.push_back({ndf.method.name, ndf.density});
  return tables;
}

NdfFits fits_of(const NdfResult& result) {
  NdfFits fits = fit_ndfs(tables_of(result), Weighting::SolidAngle);
  if (!result.spectrum) return fits;
  const std::vector<double>& lambda_q = result.spectrum->lambda_q;
  const std::vector<std::string> names = slice_names("kirchhoff_spectrum", lambda_q);
  for (std::size_t k = 0; k < lambda_q.size(); ++k)
    fits.add(fit_ndf({names[k], result.spectrum->mean.mean(k), lambda_q[k]}, Weighting::SolidAngle));
  return fits;
}

}  // namespace micro
