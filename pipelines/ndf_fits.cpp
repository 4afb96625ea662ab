#include "pipelines/ndf_fits.h"

#include <algorithm>
#include <cmath>
#include <iomanip>
#include <iterator>
#include <nlohmann/json.hpp>
#include <optional>
#include <sstream>

#include "core/error.h"
#include "core/estimate.h"
#include "io/hdf5_reader.h"
#include "pipelines/version.h"

namespace micro {
namespace {

/// λ_q in µm: "0.555".
std::string number(double lambda_q, int digits) {
  std::ostringstream text;
  text << std::setprecision(digits) << lambda_q;
  return text.str();
}

/// Only the disk means anything: elsewhere other programs leave what they like, NaN for one.
DiskTable on_the_disk(DiskTable table) {
  const Eigen::Index n = table.grid.size;
  for (Eigen::Index j = 0; j < n; ++j)
    for (Eigen::Index i = 0; i < n; ++i)
      if (!(table.grid.mz2(j, i) > 0)) table.density(j, i) = 0;
  return table;
}

/// The table of a method, or those of its wavelengths. Throws InputError where there is none.
std::vector<NdfTable> read_method(const Hdf5Reader& file, const std::string& method) {
  constexpr std::size_t kLargest = 1 << 15;
  const std::string group = "/ndf/" + method, density = group + "/density", lambdas = group + "/lambda_q_um";
  const Shape shape = file.shape(density);
  const bool spectrum = shape.size() == 3 && file.contains(lambdas) && file.shape(lambdas) == Shape{shape[0]};
  if ((shape.size() != 2 && !spectrum) || shape.back() != shape[shape.size() - 2])
    throw InputError("its density is no square table of directions");
  if (!file.has_attribute(group, "extent")) throw InputError("it has no attribute 'extent'");
  if (shape.back() > kLargest) throw InputError("its density is larger than any table of directions");
  DiskTable table = make_disk_table({static_cast<int>(shape.back()), file.number_attribute(group, "extent")});
  if (!spectrum) {
    table.density = file.read_grid<double>(density);
    return {{method, on_the_disk(std::move(table))}};
  }
  const std::vector<double> lambda_q = file.read<double>(lambdas);
  const std::vector<std::string> names = slice_names(method, lambda_q);
  const std::vector<float> values = file.read<float>(density);
  std::vector<NdfTable> tables;
  for (std::size_t k = 0; k < lambda_q.size(); ++k) {
    const auto n = static_cast<Eigen::Index>(shape.back());
    table.density =
        Eigen::Map<const Grid<float>>(values.data() + k * shape.back() * shape.back(), n, n).cast<double>();
    tables.push_back({names[k], on_the_disk(table), lambda_q[k]});
  }
  return tables;
}

/// A file with distributions, ours or another program's. Throws FileError.
Hdf5Reader open_result(const std::filesystem::path& path) {
  Hdf5Reader file(path);
  if (file.has_attribute("/", "format") && file.text_attribute("/", "format") == "microbrdf")
    file.require_complete();
  if (!file.contains("/ndf") || !file.is_group("/ndf"))
    throw FileError(path, "holds no normal distribution (/ndf/<method>/density)");
  return file;
}

void write_fit(Hdf5Writer& file, const NdfFit& ndf_fit) {
  const Fit& fit = ndf_fit.fit;
  const std::string group = "/fit/" + ndf_fit.method + "/" + std::string(name_of(fit.model));
  file.create_group(group);
  const auto set = [&](const char* name, const auto& value) { file.set_attribute(group, name, value); };
  const EllipsoidParameters& p = fit.parameters;
  set("alpha_x", p.alpha_x);
  set("alpha_y", p.alpha_y);
  set("theta_x", p.theta_x);
  set("theta_y", p.theta_y);
  set("theta_z", p.theta_z);
  set("covariance", Grid<double>(fit.covariance.array()));
  const Eigen::Matrix2d scale = fit.frame.scale();
  const std::vector<double> centre = {fit.frame.centre.x(), fit.frame.centre.y()};
  set("slope_centre", std::span<const double>(centre));
  set("slope_scale", Grid<double>(scale.array()));
  set("rel_rms", fit.rel_rms);
  set("overlap", fit.overlap);
  set("status", name_of(fit.status));
  set("iterations", fit.iterations);
  set("nodes_across", fit.nodes_across);
  set("undetermined", std::string_view(fit.undetermined));
  set("misfit", std::string_view(fit.misfit));
  set("weighting", std::string_view(ndf_fit.weighting == Weighting::Log ? "log" : "solid angle"));
  set("seconds", ndf_fit.seconds);
}

/// The file's plan with the stage "fit" as it is now; nothing if there is no plan that can be read.
std::optional<std::string> renewed_plan(const Hdf5Reader& file, const Stage& stage) {
  if (!file.contains("/plan")) return std::nullopt;
  const nlohmann::json plan = nlohmann::json::parse(file.read_text("/plan"), nullptr, false);
  if (!plan.is_array()) return std::nullopt;
  nlohmann::json renewed = nlohmann::json::array();
  for (const nlohmann::json& known : plan)
    if (!known.is_object() || known.value("stage", "") != stage.name) renewed.push_back(known);
  renewed.push_back(nlohmann::json::parse(to_json({stage}))[0]);
  return renewed.dump(1);
}

}  // namespace

std::vector<std::string> slice_names(const std::string& method, const std::vector<double>& lambda_q) {
  constexpr int kUsual = 6;
  for (const double lambda : lambda_q)
    if (!(lambda > 0 && std::isfinite(lambda)))
      throw InputError("its lambda_q_um holds " + number(lambda, kUsual) + ", which is no wavelength");
  std::vector<double> sorted = lambda_q;
  std::ranges::sort(sorted);
  sorted.erase(std::unique(sorted.begin(), sorted.end()), sorted.end());
  int digits = kUsual;
  const auto look_the_same = [&](double a, double b) { return number(a, digits) == number(b, digits); };
  while (std::ranges::adjacent_find(sorted, look_the_same) != sorted.end())
    ++digits;  // at most the seventeen that tell any two doubles apart
  std::vector<std::string> names;
  for (auto lambda = lambda_q.begin(); lambda != lambda_q.end(); ++lambda) {
    const auto before = std::count(lambda_q.begin(), lambda, *lambda);
    names.push_back(method + "_" + number(*lambda, digits) + "um" +
                    (before > 0 ? "_" + std::to_string(before + 1) : ""));
  }
  return names;
}

void NdfFits::add(NdfFits more) {
  std::ranges::move(more.fits, std::back_inserter(fits));
  std::ranges::move(more.left_out, std::back_inserter(left_out));
}

std::string_view name_of(FitModel model) {
  return model == FitModel::EllipsoidNdf ? "ellipsoid" : "beckmann";
}

NdfTables read_ndf_tables(const std::filesystem::path& path) {
  const Hdf5Reader file = open_result(path);
  NdfTables result;
  for (const std::string& method : file.children("/ndf")) {
    const std::string group = "/ndf/" + method;
    if (!file.is_group(group) || !file.contains(group + "/density")) continue;
    try {
      for (NdfTable& table : read_method(file, method))
        result.tables.push_back(std::move(table));
    } catch (const FileError& error) {
      result.left_out.push_back({method, error.fact()});
    } catch (const InputError& error) {
      result.left_out.push_back({method, error.what()});
    }
  }
  if (result.tables.empty()) {
    std::string reasons;
    for (const NotFitted& table : result.left_out)
      reasons += "; " + table.method + ": " + table.reason;
    throw FileError(path,
                    "holds no normal distribution (/ndf/<method>/density) that could be fitted" + reasons);
  }
  return result;
}

std::vector<NdfTable> read_ndf(const std::filesystem::path& path, const std::string& method) {
  const Hdf5Reader file = open_result(path);
  const std::vector<std::string> methods = file.children("/ndf");
  if (std::ranges::find(methods, method) == methods.end()) {
    std::string names;
    for (const std::string& known : methods)
      names += (names.empty() ? "" : ", ") + known;
    throw FileError(path, "holds no distribution '" + method + "'; there " +
                              (names.empty() ? "is none" : "are " + names));
  }
  try {
    return read_method(file, method);
  } catch (const FileError&) {
    throw;
  } catch (const InputError& error) {
    throw FileError(path, method + ": " + error.what());
  }
}

NdfFits fit_ndf(const NdfTable& table, Weighting weighting) {
  NdfFits result;
  try {
    for (const FitModel model : {FitModel::EllipsoidNdf, FitModel::BeckmannNdf}) {
      const Stopwatch stopwatch;
      Fit fitted = fit(table.density, model, weighting);
      result.fits.push_back({table.method, weighting, std::move(fitted), stopwatch.seconds()});
    }
  } catch (const InputError& error) {
    result.left_out.push_back({table.method, error.what()});
  }
  return result;
}

NdfFits fit_ndfs(const std::vector<NdfTable>& tables, Weighting weighting) {
  NdfFits result;
  for (const NdfTable& table : tables)
    result.add(fit_ndf(table, weighting));
  return result;
}

void write_fits(Hdf5Writer& file, const NdfFits& fits) {
  for (const NdfFit& fit : fits.fits)
    file.remove("/fit/" + fit.method);
  for (const NdfFit& fit : fits.fits)
    write_fit(file, fit);
}

void add_fits(const std::filesystem::path& source, const std::filesystem::path& output, const NdfFits& fits,
              const std::string& command) {
  if (fits.fits.empty()) return;
  const std::optional<std::string> plan = renewed_plan(Hdf5Reader(source), stage_of(fits));
  Hdf5Writer file = Hdf5Writer::amend(source, output);
  write_fits(file, fits);
  file.set_attribute("/fit", "command", std::string_view(command));
  file.set_attribute("/fit", "microbrdf_version", version());
  if (plan) {
    file.remove("/plan");
    file.write_text("/plan", *plan);
  }
  file.finish();
}

Stage stage_of(const NdfFits& fits) {
  std::size_t converged = 0;
  for (const NdfFit& fit : fits.fits)
    converged += fit.fit.status == FitStatus::Converged ? 1 : 0;
  std::ostringstream text;
  if (fits.fits.empty()) {
    text << "no table could be fitted";
  } else {
    text << "ellipsoid and Beckmann, " << converged << " of " << fits.fits.size() << " converged";
    for (const NdfFit& fit : fits.fits)
      if (fit.fit.status != FitStatus::Converged)
        text << "; " << fit.method << " " << name_of(fit.fit.model) << ": " << name_of(fit.fit.status);
  }
  for (const NotFitted& table : fits.left_out)
    text << "; " << table.method << ": " << table.reason;
  return {fits.fits.empty() ? Stage::Outcome::LeftOut : Stage::Outcome::Ran, "fit", text.str()};
}

}  // namespace micro
