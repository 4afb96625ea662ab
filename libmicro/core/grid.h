#pragma once

#include <Eigen/Core>

namespace micro {

/// rows × cols values, row-major: `grid(j, i)` is row j (along y), column i (along x).
template <typename T>
using Grid = Eigen::Array<T, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

using Vec2 = Eigen::Vector2d;
using Vec3 = Eigen::Vector3d;

}  // namespace micro
