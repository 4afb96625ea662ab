// Writes small scans of every format, FOLDER/<format>/<number>: what fuzzing starts from.
#include <cstdio>
#include <filesystem>

#include "io/small_scans_of_every_format_test.h"
#include "io/small_scans_test.h"

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: make_seeds FOLDER\n");
    return 2;
  }
  const std::filesystem::path folder = argv[1];
  std::filesystem::create_directories(folder);
  for (const auto& [format, scans] : micro::small_scans_of_every_format(folder)) {
    std::filesystem::create_directories(folder / format);
    for (std::size_t k = 0; k < scans.size(); ++k)
      micro::write_bytes(folder / format / std::to_string(k), scans[k]);
  }
  std::filesystem::remove(folder / "one");
  return 0;
}
