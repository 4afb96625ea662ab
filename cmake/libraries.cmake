# Every library microbrdf stands on; docs/dependencies.md says why each one.
find_package(PkgConfig REQUIRED)
find_package(Eigen3 3.4 REQUIRED NO_MODULE)
find_package(HDF5 REQUIRED COMPONENTS C HL)
# Debian's Imath exports a Python binding that its package does not hold, and says so at length (as status
# messages, for nothing that is used here).
set(CMAKE_MESSAGE_LOG_LEVEL WARNING)
find_package(OpenEXR REQUIRED CONFIG)
unset(CMAKE_MESSAGE_LOG_LEVEL)
find_package(PNG REQUIRED)
find_package(ZLIB REQUIRED)
find_package(pugixml REQUIRED)
find_package(CLI11 REQUIRED)
find_package(nlohmann_json REQUIRED)
find_package(OpenSSL REQUIRED COMPONENTS Crypto)
# libzip's own CMake package wants the programs that Debian packs apart.
pkg_check_modules(ZIP REQUIRED IMPORTED_TARGET libzip)
pkg_check_modules(FFTW REQUIRED IMPORTED_TARGET fftw3)
pkg_check_modules(FFTWF REQUIRED IMPORTED_TARGET fftw3f)
pkg_check_modules(HWY REQUIRED IMPORTED_TARGET libhwy)
find_path(RANDOM123_INCLUDE_DIR Random123/philox.h REQUIRED)
