#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <thread>

#include "core/error.h"
#include "io/hdf5_reader.h"
#include "io/hdf5_writer.h"
#include "testing/temporary_folder.h"

namespace micro {
namespace {

TEST(Hdf5File, IsAmendedAsideAndRenamed) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "a.h5", other = folder.path() / "b.h5";
  {
    Hdf5Writer writer(path);
    writer.set_attribute("/", "format", "microbrdf");
    writer.set_attribute("/", "kept", 3);
    writer.write_text("/plan", "old");
    writer.create_group("/fit/old");
    writer.finish();
  }
  const auto amend = [&](const std::filesystem::path& to) {
    Hdf5Writer writer = Hdf5Writer::amend(path, to);
    writer.remove("/plan");
    writer.remove("/nothing");
    writer.remove("/fit");
    writer.write_text("/plan", "new");
    writer.create_group("/fit/new");
    writer.set_attribute("/fit/new", "matrix", Grid<double>::Constant(2, 3, 0.5));
    EXPECT_EQ(Hdf5Reader(path).read_text("/plan"), "old") << "the old file stays until the new one is whole";
    return writer;
  };
  { const Hdf5Writer dropped = amend(path); }
  EXPECT_EQ(Hdf5Reader(path).read_text("/plan"), "old");
  amend(other).finish();
  EXPECT_EQ(Hdf5Reader(path).read_text("/plan"), "old");
  amend(path).finish();
  for (const auto& file : {path, other}) {
    const Hdf5Reader reader(file);
    reader.require_complete();
    EXPECT_EQ(reader.read_text("/plan"), "new");
    EXPECT_EQ(reader.integer_attribute("/", "kept"), 3);
    EXPECT_EQ(reader.children("/fit"), std::vector<std::string>{"new"});
    EXPECT_EQ(reader.numbers_attribute("/fit/new", "matrix").size(), 6u);
  }
  EXPECT_THROW(Hdf5Writer::amend(folder.path() / "missing.h5", path), FileError);
  std::ofstream(other) << "no HDF5 at all";
  EXPECT_THROW(Hdf5Writer::amend(other, other), FileError);
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder.path()), {}), 2)
      << "nothing stays behind";
}

TEST(Hdf5File, GivesBackWhatWasWritten) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "a.h5";
  Grid<float> grid(3, 5);
  for (Eigen::Index k = 0; k < grid.size(); ++k)
    grid.data()[k] = static_cast<float>(k) / 7;
  grid(1, 2) = NAN;
  const std::vector<std::int32_t> block = {1, -2, 3, -4, 5, -6, 7, 8};
  const std::vector<double> x = {0, 0.5, 1, 1.5, 2};
  Hdf5Writer writer(path);
  writer.set_attribute("/", "format", "microbrdf");
  writer.write("/ndf/filtered/density", grid, 4);
  writer.write("/plain", grid);
  writer.write<std::int32_t>("/block", block, {2, 2, 2});
  writer.write<double>("/x", x, {5});
  writer.make_scale("/x", "x / µm");
  writer.attach_scale("/plain", 1, "/x", "x");
  writer.write_text("/plan", "{\"µ\": 1}");
  writer.set_attribute("/ndf/filtered", "extent", 1.25);
  writer.set_attribute("/ndf/filtered", "scans", 7);
  writer.set_attribute("/ndf/filtered", "scans", 8);
  writer.set_attribute("/ndf/filtered", "alpha", x);
  const std::array<std::string, 2> names = {"alpha.x", "θ"};
  writer.set_attribute("/ndf/filtered", "channels", names);
  EXPECT_FALSE(std::filesystem::exists(path)) << "the final name appears only when the file is whole";
  writer.finish();

  const Hdf5Reader reader(path);
  reader.require_complete();
  for (const char* name : {"/ndf/filtered/density", "/plain"}) {
    const auto back = reader.read_grid<float>(name);
    ASSERT_EQ(back.rows(), 3);
    ASSERT_EQ(back.cols(), 5);
    for (Eigen::Index k = 0; k < grid.size(); ++k) {
      EXPECT_EQ(std::isnan(back.data()[k]), std::isnan(grid.data()[k])) << k;
      if (!std::isnan(grid.data()[k])) {
        EXPECT_EQ(back.data()[k], grid.data()[k]) << k;
      }
    }
  }
  EXPECT_EQ(reader.shape("/block"), (Shape{2, 2, 2}));
  EXPECT_EQ(reader.read<std::int32_t>("/block"), block);
  EXPECT_EQ(reader.read<double>("/x"), x);
  EXPECT_EQ(reader.read_text("/plan"), "{\"µ\": 1}");
  EXPECT_EQ(reader.number_attribute("/ndf/filtered", "extent"), 1.25);
  EXPECT_EQ(reader.integer_attribute("/ndf/filtered", "scans"), 8);
  EXPECT_EQ(reader.numbers_attribute("/ndf/filtered", "alpha"), x);
  EXPECT_EQ(reader.texts_attribute("/ndf/filtered", "channels"), std::vector<std::string>({"alpha.x", "θ"}));
  EXPECT_EQ(reader.children("/ndf"), std::vector<std::string>{"filtered"});
  EXPECT_TRUE(reader.is_group("/ndf"));
  EXPECT_FALSE(reader.is_group("/plain"));
  EXPECT_FALSE(reader.contains("/ndf/naive/density"));
  EXPECT_FALSE(reader.has_attribute("/ndf", "extent"));
}

TEST(Hdf5File, AnotherProgramSeesDataAndAxes) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "a.h5";
  if (std::system("/usr/bin/python3 -c 'import h5py' 2>/dev/null") != 0)
    GTEST_SKIP() << "NOT CHECKED: /usr/bin/python3 has no h5py";
  Hdf5Writer writer(path);
  writer.write<float>("/g/z", std::array<float, 6>{0, 1, 2, 3, 4, 5}, {2, 3}, 1);
  writer.write<double>("/g/x", std::array<double, 3>{10, 20, 30}, {3});
  writer.make_scale("/g/x", "x");
  writer.attach_scale("/g/z", 1, "/g/x", "x / µm");
  writer.set_attribute("/g", "unit", "1/sr");
  writer.finish();
  const std::string program =
      "import h5py\n"
      "f = h5py.File('" +
      path.string() +
      "')\n"
      "z = f['g/z']\n"
      "assert z[()].tolist() == [[0, 1, 2], [3, 4, 5]] and z.dtype == 'f4' and z.compression == 'gzip'\n"
      "assert z.dims[1].label == 'x / µm' and z.dims[1][0][()].tolist() == [10, 20, 30]\n"
      "assert f['g'].attrs['unit'] == '1/sr' and f.attrs['complete'] == 1\n";
  const auto script = folder.path() / "check.py";
  std::ofstream(script) << program;
  EXPECT_EQ(std::system(("/usr/bin/python3 " + script.string()).c_str()), 0);
}

TEST(Hdf5File, SparsePlacesAloneTakeRoom) {
  const TemporaryFolder folder;
  const std::array<float, 4> first = {1, 2, 3, 4}, last = {5, 6, 7, 8};
  const auto table = [&](std::size_t k) {
    return k == 1 ? std::span<const float>() : std::span<const float>(k == 0 ? first : last);
  };
  const auto path = folder.path() / "a.h5";
  Hdf5Writer writer(path);
  writer.write_sparse("/few", {2, 3, 2, 2}, 1, std::array<std::int64_t, 3>{1, 2, 5}, table);
  writer.finish();
  const std::vector<float> values = Hdf5Reader(path).read<float>("/few");
  ASSERT_EQ(values.size(), 24U);
  for (std::size_t k = 0; k < values.size(); ++k)
    if (k / 4 == 1 || k / 4 == 5)
      EXPECT_EQ(values[k], k < 8 ? first[k % 4] : last[k % 4]);
    else
      EXPECT_TRUE(std::isnan(values[k])) << k;
  // Four million places, 18 GB if all were there; the rest of the file is the index of its chunks.
  const auto large = folder.path() / "large.h5";
  const std::vector<float> many(33 * 33, 1);
  Hdf5Writer sparse(large);
  sparse.write_sparse("/few", {2000, 2000, 33, 33}, 1, std::array<std::int64_t, 2>{7, 3'999'999},
                      [&](std::size_t) { return std::span<const float>(many); });
  sparse.finish();
  EXPECT_LT(std::filesystem::file_size(large), 100'000U);
}

TEST(Hdf5File, NothingStaysBehindWithoutFinish) {
  const TemporaryFolder folder;
  {
    Hdf5Writer writer(folder.path() / "a.h5");
    writer.write<float>("/z", std::array<float, 2>{1, 2}, {2});
  }
  EXPECT_TRUE(std::filesystem::is_empty(folder.path()));
}

TEST(Hdf5File, RefusesWhatIsCutOrForeign) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "a.h5";
  Hdf5Writer writer(path);
  writer.write<float>("/z", std::array<float, 4>{1, 2, 3, 4}, {2, 2});
  writer.finish();
  EXPECT_THROW(Hdf5Reader(path).require_complete(), FileError) << "no format attribute";
  const Hdf5Reader reader(path);
  EXPECT_THROW(reader.read<float>("/missing"), FileError);
  EXPECT_THROW(reader.number_attribute("/", "missing"), FileError);
  EXPECT_THROW(reader.text_attribute("/", "complete"), FileError);
  EXPECT_THROW(reader.read_text("/z"), FileError);
  EXPECT_THROW(reader.children("/z/no"), FileError);
  EXPECT_THROW(Hdf5Reader(folder.path() / "none.h5"), FileError);
  std::ofstream(folder.path() / "text.h5") << "not HDF5 at all";
  EXPECT_THROW(Hdf5Reader(folder.path() / "text.h5"), FileError);
  EXPECT_THROW(Hdf5Writer(folder.path() / "no" / "such" / "a.h5"), FileError);
  EXPECT_THROW(Hdf5Writer(folder.path()), FileError);
}

TEST(Hdf5File, FailureToWriteNamesTheFinalFile) {
  const TemporaryFolder folder;
  const auto path = folder.path() / "a.h5";
  Hdf5Writer writer(path);
  writer.write<float>("/z", std::array<float, 1>{1}, {1});
  try {
    writer.write<float>("/z", std::array<float, 1>{1}, {1});
    FAIL() << "the same dataset twice";
  } catch (const FileError& error) {
    EXPECT_EQ(error.file(), path);
    EXPECT_NE(std::string(error.what()).find("/z"), std::string::npos) << error.what();
  }
}

TEST(Hdf5File, ManyThreadsReadAndWrite) {
  const TemporaryFolder folder;
  std::vector<std::thread> threads;
  std::array<double, 8> sums{};
  for (std::size_t t = 0; t < sums.size(); ++t)
    threads.emplace_back([&, t] {
      const auto path = folder.path() / (std::to_string(t) + ".h5");
      const std::vector<double> values(1000, static_cast<double>(t));
      Hdf5Writer writer(path);
      writer.write<double>("/a/b", values, {10, 100}, 3);
      writer.finish();
      for (const double value : Hdf5Reader(path).read<double>("/a/b"))
        sums[t] += value;
    });
  for (auto& thread : threads)
    thread.join();
  for (std::size_t t = 0; t < sums.size(); ++t)
    EXPECT_EQ(sums[t], 1000. * static_cast<double>(t));
}

}  // namespace
}  // namespace micro
