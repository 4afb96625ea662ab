#pragma once

#include <filesystem>
#include <string>
#include <vector>

#include "io/png.h"
#include "pipelines/ndf_of_scans.h"

namespace micro {

/// Writes result.h5 (docs/design.md has its layout): /scans, /ndf/<method>, /fit and /plan; whole or absent.
/// `command` is what the user typed. Throws FileError.
void write_result(const std::filesystem::path& path, const NdfResult& result, const std::string& command);

/// Writes one table as OpenEXR: channel Y, 1/sr, m_y downwards; extent, unit and method as attributes.
void write_ndf_picture(const std::filesystem::path& path, const NdfOfScans& ndf);

/// Writes a PNG contact sheet: the scans that have a thumbnail, then every NDF, each with its name.
void write_contact_sheet(const std::filesystem::path& path, const NdfResult& result);

/// Tables on one grid (at least one) beside each other, all to the extent that the widest of them needs:
/// their widths may be compared by eye [Dong15 Fig. 5]. Each is drawn down from its own peak.
Picture comparison_sheet(const std::vector<NdfOfScans>& ndfs);

/// Writes what was done as text for people: the scans' table, the NDFs' table, that of
/// their fits and the plan.
void write_report(const std::filesystem::path& path, const NdfResult& result, const ScanListing& listing,
                  const std::string& command);

}  // namespace micro
