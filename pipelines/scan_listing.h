#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace micro {

/// A scan to read, and the name it goes by in results: as typed, or relative to the directory it was found in
/// if that is the only one named.
struct ListedScan {
  std::filesystem::path path;
  std::string source;
};

/// A file or folder that is not taken, and why.
struct Skipped {
  std::string source;
  std::string reason;
};

/// What there is to do.
struct ScanListing {
  std::vector<ListedScan> scans;  ///< sorted by source within each directory, directories in the order given
  std::vector<Skipped> skipped;
};

/// Lists the scans that are named or lie in the named directories, recursively. In a directory what is not a
/// scan by its content is skipped and listed, and so are formats that are read only when named (plain text,
/// .npy, our own results); a file that is named is always taken, and fails later if it is no scan or not
/// there. The output (`leave_out`, a folder or a file) is skipped. Links to folders are not followed, those
/// to files are. Throws FileError if a named directory cannot be read.
ScanListing list_scans(const std::vector<std::filesystem::path>& paths,
                       const std::optional<std::filesystem::path>& leave_out = {});

}  // namespace micro
