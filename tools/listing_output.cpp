#include "tools/listing_output.h"

#include <algorithm>
#include <cstdio>
#include <iostream>

#include "core/error.h"
#include "io/printable.h"

namespace micro::tools {

void require_scans(const ScanListing& listing, const std::vector<std::string>& paths) {
  if (!listing.scans.empty()) return;
  std::string what;
  for (const std::string& path : paths)
    what += (what.empty() ? "" : ", ") + printable_name(path);
  what += paths.size() == 1 ? ": holds no scan" : ": hold no scan";
  if (const std::size_t skipped = listing.skipped.size(); skipped > 0) {
    const Skipped& first = listing.skipped.front();
    what += " (skipped " + printable_name(first.source) + ": " + first.reason;
    if (skipped > 1) what += "; and " + std::to_string(skipped - 1) + " more";
    what += ")";
  }
  throw InputError(what);
}

std::string printable_name(const std::string& file) {
  return printable(file, file.size());
}

void print_failed(const std::string& source, const std::string& message) {
  std::fprintf(stderr, "microbrdf: %s: %s\n", printable_name(source).c_str(), message.c_str());
}

nlohmann::json report_failed(const std::vector<ScanRecord>& scans) {
  nlohmann::json failed = nlohmann::json::array();
  for (const ScanRecord& scan : scans) {
    if (!scan.failure) continue;
    print_failed(scan.source, *scan.failure);
    failed.push_back({{"source", scan.source}, {"message", *scan.failure}});
  }
  return failed;
}

nlohmann::json skipped_json(const ScanListing& listing) {
  nlohmann::json skipped = nlohmann::json::array();
  for (const Skipped& file : listing.skipped)
    skipped.push_back({{"source", file.source}, {"reason", file.reason}});
  return skipped;
}

void print_skipped(const ScanListing& listing) {
  if (listing.skipped.empty()) return;
  std::cout << "Skipped " << listing.skipped.size() << ":\n";
  constexpr std::size_t kShown = 10;
  const std::size_t shown = std::min(kShown, listing.skipped.size());
  for (std::size_t k = 0; k < shown; ++k)
    std::cout << "  " << printable_name(listing.skipped[k].source) << ": " << listing.skipped[k].reason
              << '\n';
  if (listing.skipped.size() > shown) std::cout << "  and " << listing.skipped.size() - shown << " more\n";
}

}  // namespace micro::tools
