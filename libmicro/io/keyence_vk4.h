#pragma once

#include "io/scan.h"

namespace micro {

bool is_keyence_vk4(const FileHead& head);
HeightField read_keyence_vk4(const std::filesystem::path& path, const ReadOptions& options);

/// Keyence .vk4 of a laser scanning microscope (VK series). Heights are unsigned integers; their unit and the
/// distance of points are whole picometres. There is no mark for a missing point.
inline constexpr ScanFormat kKeyenceVk4 = {"keyence-vk4", "Keyence .vk4", ScanFormat::Listed::WhenFound,
                                           is_keyence_vk4, read_keyence_vk4};

}  // namespace micro
