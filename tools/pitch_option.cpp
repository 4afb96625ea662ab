#include "tools/pitch_option.h"

#include "tools/units.h"

namespace micro::tools {

CLI::Option* add_pitch(CLI::App& app, ReadOptions& options) {
  return app
      .add_option_function<std::vector<std::string>>(
          "--pitch",
          [&options](const std::vector<std::string>& texts) {
            options.pitch_x = parse_length(texts.front());
            if (texts.size() > 1) options.pitch_y = parse_length(texts.back());
            for (const auto& length : {options.pitch_x, options.pitch_y})
              if (length && !(*length > 0)) throw CLI::ValidationError("--pitch", "must be positive");
          },
          "Distance between points, P or X,Y, for files that don't say it (.npy, plain text)")
      ->delimiter(',')
      ->expected(1, 2)
      ->type_name("LENGTH");
}

}  // namespace micro::tools
