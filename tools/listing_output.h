#pragma once

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "pipelines/scan_listing.h"
#include "pipelines/scan_record.h"

namespace micro::tools {

/// Throws InputError, with a sentence, if the listing of `paths` holds no scan.
void require_scans(const ScanListing& listing, const std::vector<std::string>& paths);

/// The name of a file for a sentence: hostile ones steer terminals.
std::string printable_name(const std::string& file);

/// Says on stderr which scan failed and why.
void print_failed(const std::string& source, const std::string& message);

/// Says on stderr which scans failed and why; the same as [{"source", "message"}, …].
nlohmann::json report_failed(const std::vector<ScanRecord>& scans);

/// What was skipped: [{"source", "reason"}, …].
nlohmann::json skipped_json(const ScanListing& listing);

/// What was skipped, for people on stdout: the first few, and how many more. Nothing if nothing was.
void print_skipped(const ScanListing& listing);

}  // namespace micro::tools
