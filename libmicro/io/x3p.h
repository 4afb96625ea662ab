#pragma once

#include "io/scan.h"

namespace micro {

bool is_x3p(const FileHead& head);
HeightField read_x3p(const std::filesystem::path& path, const ReadOptions& options);

/// Writes the heights, the mean included, as 64-bit floats in metres, missing points as NaN, both axes with
/// their pitch, and the checksums. Throws FileError.
void write_x3p(const std::filesystem::path& path, const HeightField& surface);

constexpr std::string_view kZipSignature = "PK\3\4";

/// The offsets of the axes CX and CY; none if neither is given.
std::optional<StageWindow> stage_of_x3p(const std::filesystem::path& path);

/// X3P (ISO 25178-72, ISO 5436-2): a zip archive with main.xml and bindata/data.bin, at its top or in a
/// folder. Heights are 16- or 32-bit signed integers times an increment, or 32- or 64-bit floats in metres;
/// missing is NaN, ±inf, or a 0 bit of the file of valid points. MD5 checksums that are there must be right.
inline constexpr ScanFormat kX3p = {
    "x3p",       "X3P .x3p (ISO 25178-72)", ScanFormat::Listed::WhenFound, is_x3p, read_x3p, kZipSignature,
    stage_of_x3p};

}  // namespace micro
