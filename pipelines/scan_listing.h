#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace micro {

/// A scan to read, and the name it goes by in results: relative to the directory it was found in.
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
/// .npy, our own files); a file that is named is always taken, and fails later if it is no scan. A folder
/// that is the output (`leave_out`) is skipped. Links to folders are not followed. Throws FileError if a
/// named path does not exist or a named directory cannot be read.
ScanListing list_scans(const std::vector<std::filesystem::path>& paths,
                       const std::optional<std::filesystem::path>& leave_out = {});

}  // namespace micro
