#pragma once

#include <filesystem>
#include <stdexcept>
#include <string>

namespace micro {

/// Bad input, told in one clear sentence. Bugs are assertions; numbers that did not come out are part of a
/// result.
class InputError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Bad input that sits in a file: the sentence names the file and the fact.
class FileError : public InputError {
 public:
  FileError(const std::filesystem::path& file, const std::string& fact)
      : InputError(file.string() + ": " + fact), file_(file), fact_(fact) {}
  const std::filesystem::path& file() const { return file_; }
  const std::string& fact() const { return fact_; }

 private:
  std::filesystem::path file_;
  std::string fact_;
};

}  // namespace micro
