set(CMAKE_CXX_STANDARD 20)
set(CMAKE_CXX_STANDARD_REQUIRED ON)
set(CMAKE_CXX_EXTENSIONS OFF)
set(CMAKE_EXPORT_COMPILE_COMMANDS ON)
if(NOT CMAKE_BUILD_TYPE AND NOT CMAKE_CONFIGURATION_TYPES)
  set(CMAKE_BUILD_TYPE Release)
endif()

# NaN means "missing", so nothing that assumes finite numbers may ever be switched on. The two flags below keep
# NaN, infinity and signed zero exact; they only drop errno and trapping, which nobody here reads.
add_library(micro_flags INTERFACE)
target_compile_options(micro_flags INTERFACE -fno-math-errno -fno-trapping-math)

# Sanitizers touch every object and the link, tests and consumers of the static library included.
set(MICRO_SANITIZE "" CACHE STRING "Sanitizers to build with, as -fsanitize= takes them")
if(MICRO_SANITIZE)
  set(MICRO_SANITIZE_FLAGS -fsanitize=${MICRO_SANITIZE} -fno-sanitize-recover=all -fno-omit-frame-pointer)
  add_compile_options(${MICRO_SANITIZE_FLAGS})
  add_link_options(${MICRO_SANITIZE_FLAGS})
endif()

add_library(micro_warnings INTERFACE)
target_compile_options(micro_warnings INTERFACE -Wall -Wextra -Wpedantic -Wshadow -Wconversion -Wno-sign-conversion)
if(CMAKE_CXX_COMPILER_ID STREQUAL GNU AND CMAKE_CXX_COMPILER_VERSION VERSION_LESS 13)
  # When it optimises, g++ 12 takes "text" + std::string for a copy onto itself (GCC bug 105329).
  target_compile_options(micro_warnings INTERFACE -Wno-restrict)
endif()
option(MICRO_WARNINGS_ARE_ERRORS "Stop at the first warning" OFF)
if(MICRO_WARNINGS_ARE_ERRORS)
  target_compile_options(micro_warnings INTERFACE -Werror)
endif()
