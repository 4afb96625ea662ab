#include "io/zip_archive.h"

#include <zip.h>

#include <memory>
#include <new>

#include "core/error.h"
#include "io/atomic_file.h"
#include "io/printable.h"

namespace micro {
namespace {

/// Deflate cannot shrink anything by more than 1032 : 1.
constexpr std::uint64_t kMostCompression = 1100;

std::string text_of(zip_error_t& error) {
  std::string text = zip_error_strerror(&error);
  zip_error_fini(&error);
  return text;
}

}  // namespace

ZipArchive::ZipArchive(const std::filesystem::path& path) : path_(path) {
  int code = 0;
  archive_ = zip_open(path.c_str(), ZIP_RDONLY, &code);
  if (archive_) return;
  zip_error_t error;
  zip_error_init_with_code(&error, code);
  throw FileError(path, "is no readable zip archive: " + text_of(error));
}

ZipArchive::~ZipArchive() {
  zip_discard(archive_);
}

std::vector<std::string> ZipArchive::names() const {
  std::vector<std::string> names;
  const zip_int64_t count = zip_get_num_entries(archive_, 0);
  for (zip_int64_t k = 0; k < count; ++k)
    if (const char* name = zip_get_name(archive_, static_cast<zip_uint64_t>(k), 0)) names.emplace_back(name);
  return names;
}

std::optional<std::vector<std::byte>> ZipArchive::read(const std::string& name, std::uint64_t most) const {
  const zip_int64_t located = zip_name_locate(archive_, name.c_str(), ZIP_FL_NOCASE);
  if (located < 0) return std::nullopt;
  const auto index = static_cast<zip_uint64_t>(located);
  const auto fail = [&](const std::string& fact) {
    throw FileError(path_, "its " + in_quotes(name) + " " + fact);
  };
  zip_stat_t stat;
  zip_stat_init(&stat);
  if (zip_stat_index(archive_, index, 0, &stat) != 0 || (stat.valid & ZIP_STAT_SIZE) == 0 ||
      (stat.valid & ZIP_STAT_COMP_SIZE) == 0)
    fail("has no size in the zip archive");
  if (stat.size > most)
    fail("has " + std::to_string(stat.size) + " bytes, more than the " + std::to_string(most) +
         " that make sense");
  // A directory may promise anything: hold it against the bytes that are there.
  if (stat.size / kMostCompression > stat.comp_size) fail("says that it is larger than it can be");
  const std::unique_ptr<zip_file_t, decltype(&zip_fclose)> file(zip_fopen_index(archive_, index, 0),
                                                                &zip_fclose);
  if (!file) fail(std::string("cannot be unpacked: ") + zip_strerror(archive_));
  std::vector<std::byte> bytes(stat.size);
  std::uint64_t done = 0;
  while (done < stat.size) {
    const zip_int64_t count = zip_fread(file.get(), bytes.data() + done, stat.size - done);
    if (count < 0) fail(std::string("cannot be unpacked: ") + zip_file_strerror(file.get()));
    if (count == 0) fail("is cut");
    done += static_cast<std::uint64_t>(count);
  }
  // Only at its end does the library hold a member against its check sum.
  std::byte beyond;
  if (zip_fread(file.get(), &beyond, 1) != 0) fail("cannot be unpacked: its check sum (CRC-32) is wrong");
  return bytes;
}

void write_zip(const std::filesystem::path& path, const std::vector<ZipMember>& members) {
  zip_error_t error;
  zip_error_init(&error);
  const auto fail = [&](const std::string& reason) { throw FileError(path, "cannot be packed: " + reason); };
  const std::unique_ptr<zip_source_t, decltype(&zip_source_free)> packed(
      zip_source_buffer_create(nullptr, 0, 0, &error), &zip_source_free);
  if (!packed) fail(text_of(error));
  zip_source_keep(packed.get());  // the archive takes one reference
  zip_t* opened = zip_open_from_source(packed.get(), ZIP_TRUNCATE, &error);
  if (!opened) {
    zip_source_free(packed.get());
    fail(text_of(error));
  }
  std::unique_ptr<zip_t, decltype(&zip_discard)> archive(opened, &zip_discard);
  for (const ZipMember& member : members) {
    zip_source_t* source = zip_source_buffer(archive.get(), member.bytes.data(), member.bytes.size(), 0);
    const zip_int64_t index =
        source ? zip_file_add(archive.get(), member.name.c_str(), source, ZIP_FL_ENC_UTF_8) : -1;
    constexpr zip_uint16_t first_of_1980 = 0x21;
    if (index < 0 ||
        zip_file_set_dostime(archive.get(), static_cast<zip_uint64_t>(index), 0, first_of_1980, 0) != 0) {
      if (index < 0) zip_source_free(source);
      fail(zip_strerror(archive.get()));
    }
  }
  if (zip_close(archive.get()) != 0) fail(zip_strerror(archive.get()));
  archive.release();

  std::vector<std::byte> bytes;
  zip_stat_t stat;
  zip_stat_init(&stat);
  if (zip_source_stat(packed.get(), &stat) == 0 && zip_source_open(packed.get()) == 0) {
    bytes.resize(stat.size);
    const zip_int64_t count = zip_source_read(packed.get(), bytes.data(), bytes.size());
    zip_source_close(packed.get());
    if (count == static_cast<zip_int64_t>(stat.size)) return write_file(path, bytes);
  }
  fail("the packed bytes cannot be read back");
}

}  // namespace micro
