#pragma once

#include "io/scan.h"

namespace micro {

bool is_text_matrix(const FileHead& head);
HeightField read_text_matrix(const std::filesystem::path& path, const ReadOptions& options);

/// Plain text, a line per row, heights in µm. The first line with numbers decides how cells are parted: by
/// semicolons, else tabs, else commas, else blanks. `#` begins a comment. A missing point is an empty cell
/// (not at the end of a line, where a separator closes the line), `nan`, `inf`, `NA`, `BAD` or `*`. Decimal
/// commas and ragged rows are refused. The pitch comes from the user.
inline constexpr ScanFormat kTextMatrix = {"text", "plain text matrix (heights in µm)",
                                           ScanFormat::Listed::WhenNamed, is_text_matrix, read_text_matrix};

}  // namespace micro
