#include "io/small_scans_of_every_format_test.h"

#include "io/exr.h"
#include "io/microbrdf_hdf5.h"
#include "io/npy.h"
#include "io/small_hdf5_scans_test.h"
#include "io/small_profiler_scans_test.h"
#include "io/small_scans_test.h"
#include "io/x3p.h"

namespace micro {

std::map<std::string, std::vector<std::vector<std::byte>>> small_scans_of_every_format(
    const std::filesystem::path& folder) {
  const auto path = folder / "one";
  const HeightField surface = make_height_field(Grid<double>::Random(3, 4), 0.25, 0.5);
  const auto bytes_of = [](const std::string& text) {
    const auto* begin = reinterpret_cast<const std::byte*>(text.data());
    return std::vector<std::byte>(begin, begin + text.size());
  };
  const auto written = [&](auto&& write) {
    std::filesystem::remove(path);
    write();
    return read_bytes(path);
  };
  std::map<std::string, std::vector<std::vector<std::byte>>> files;
  files["zygo-dat"] = {small_dat({}), small_dat({.format = 3, .phase_res = 2, .sign = 1})};
  files["zygo-asc"] = {bytes_of(small_asc("1 2 3 4 \n#\n")), bytes_of(small_asc(""))};
  files["zygo-xyz"] = {bytes_of(small_xyz())};
  files["digital-surf"] = {small_surf({}), small_surf({.macintosh = true, .bits = 32}),
                           compressed_surf(small_surf({}), 12)};
  files["sdf"] = {bytes_of(small_sdf_ascii()), small_sdf_binary({.type = 5, .olympus = true}),
                  small_sdf_binary({.type = 7})};
  files["wyko-opd"] = {small_opd({}), small_opd({.floats = true, .name = "Raw"})};
  files["sensofar-plu"] = {small_plu()};
  files["keyence-vk4"] = {small_vk4({}), small_vk4({.bits = 16}), small_vk4({.bits = 8})};
  files["gsf"] = {bytes_of(small_gsf())};
  files["npy"] = {written([&] { write_npy(path, surface); })};
  files["text"] = {bytes_of("0.5 1.5 2.5\n3.5 4.5 5.5\n"), bytes_of("# x\n1;;nan\n+2;BAD;1e3\n")};
  files["x3p"] = {small_x3p({}), small_x3p({.type = 'I', .folder = "a/"}),
                  written([&] { write_x3p(path, surface); })};
  files["exr"] = {written([&] { write_exr(path, {{"Y", surface.z}}, {{"unit", "um"}}); })};
  files["microbrdf-hdf5"] = {written(
      [&] { write_microbrdf_hdf5(path, surface, {.version = "0", .created = "now", .command = "test"}); })};
  files["zygo-datx"] = {written([&] { write_small_datx(path, {}); }), written([&] {
                          write_small_datx(path, {.unit = "Fringes", .surfaces = 2, .hard_link = true});
                        }),
                        written([&] { write_small_datx(path, {.converter_fields = 5, .metadata = false}); })};
  for (const Hdf5Layout layout : {Hdf5Layout::Earliest, Hdf5Layout::Latest})
    for (const Hdf5Storage storage : {Hdf5Storage::Contiguous, Hdf5Storage::Deflated}) {
      files["microbrdf-hdf5"].push_back(written([&] { write_small_height_file(path, layout, storage); }));
      files["zygo-datx"].push_back(written(
          [&] { write_small_datx(path, {.converter_fields = 5, .layout = layout, .storage = storage}); }));
    }
  return files;
}

}  // namespace micro
