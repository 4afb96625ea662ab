#include "io/signature_file.h"

#include <fstream>
#include <numbers>
#include <sstream>
#include <string>

#include "core/error.h"

namespace micro {

Signature read_signature(const std::filesystem::path& path) {
  std::ifstream file(path);
  if (!file) throw FileError(path, "cannot be opened");
  Signature signature;
  std::string line;
  for (int number = 1; std::getline(file, line); ++number) {
    line.resize(std::min(line.find('#'), line.size()));
    std::istringstream words(line);
    double angle = 0, response = 0;
    if ((words >> std::ws).eof()) continue;
    if (!(words >> angle >> response) || !(words >> std::ws).eof())
      throw FileError(path, "line " + std::to_string(number) + " is no pair of angle (degrees) and response");
    signature.angle.push_back(angle * std::numbers::pi / 180);
    signature.response.push_back(response);
  }
  try {
    require_valid(signature);
  } catch (const FileError&) {
    throw;
  } catch (const InputError& error) {
    throw FileError(path, error.what());
  }
  return signature;
}

}  // namespace micro
