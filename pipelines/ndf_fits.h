#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "distribution/disk_table.h"
#include "fit/fit.h"
#include "io/hdf5_writer.h"
#include "pipelines/plan.h"

namespace micro {

/// The table of one method, as it stands under /ndf/<method>, or one wavelength of a spectrum, see
/// slice_names().
struct NdfTable {
  std::string method;
  DiskTable density;                    ///< 1/sr
  std::optional<double> lambda_q = {};  ///< µm, of a spectrum's
};

/// One model fitted to one method's table.
struct NdfFit {
  std::string method;
  Weighting weighting = Weighting::SolidAngle;
  Fit fit;
  double seconds = 0;
};

/// What could not be fitted, and why.
struct NotFitted {
  std::string method, reason;
};

/// The fits of a file or a run.
struct NdfFits {
  std::vector<NdfFit> fits;  ///< for each method the ellipsoid, then Beckmann
  std::vector<NotFitted> left_out;

  void add(NdfFits more);
};

/// Names of a spectrum's wavelengths λ_q (µm), each another: <method>_<λ_q>um, with as many digits as tell
/// them apart; equal ones are numbered, "…um_2". Throws InputError unless all are positive and finite.
std::vector<std::string> slice_names(const std::string& method, const std::vector<double>& lambda_q);

/// "ellipsoid" or "beckmann".
std::string_view name_of(FitModel model);

/// Tables of a file, and what else stands under /ndf.
struct NdfTables {
  std::vector<NdfTable> tables;
  std::vector<NotFitted> left_out;
};

/// Reads every /ndf/<method>/density with its `extent`, [N, N] or for wavelengths lambda_q_um [L, N, N],
/// whoever wrote the file. Throws FileError if it is one of ours that was not finished, or holds no such
/// table.
NdfTables read_ndf_tables(const std::filesystem::path& path);

/// The table of /ndf/<method> alone, or those of its wavelengths. Throws FileError as above, or naming the
/// methods that are there.
std::vector<NdfTable> read_ndf(const std::filesystem::path& path, const std::string& method);

/// Fits ellipsoid and Beckmann to a table, or to each [Dong15 §8, Fig. 12]. Tables that cannot be fitted are
/// left out, with the reason.
NdfFits fit_ndf(const NdfTable& table, Weighting weighting);
NdfFits fit_ndfs(const std::vector<NdfTable>& tables, Weighting weighting);

/// What a plan says of them.
Stage stage_of(const NdfFits& fits);

/// Writes /fit/<method>/<model> in place of what stood under /fit/<method>; fits of other methods stay.
void write_fits(Hdf5Writer& file, const NdfFits& fits);

/// Writes `output` as a copy of `source` with the fits in it, and what /plan says of the stage "fit" renewed;
/// both may be the same file. Writes nothing if nothing was fitted. `command` is what the user typed. Throws
/// FileError.
void add_fits(const std::filesystem::path& source, const std::filesystem::path& output, const NdfFits& fits,
              const std::string& command);

}  // namespace micro
