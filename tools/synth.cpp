#include <array>
#include <cmath>
#include <filesystem>
#include <functional>
#include <memory>
#include <nlohmann/json.hpp>
#include <numbers>
#include <string>
#include <vector>

#include "core/error.h"
#include "height/brushed_surface.h"
#include "height/gaussian_surface.h"
#include "height/make_holes.h"
#include "height/shaped_surface.h"
#include "tools/commands.h"
#include "tools/common_options.h"
#include "tools/scan_output.h"
#include "tools/units.h"

namespace micro::tools {
namespace {

/// What every kind of surface understands.
struct Options {
  CommonOptions common;
  SyntheticGrid grid;
  Border border = Border::Open;
  std::uint64_t seed = 1;
  Holes holes;
  std::vector<std::string> pitch;
  std::filesystem::path output;
};

/// Makes the surface once the command line is parsed. Throws InputError if the options make none.
using Make = std::function<HeightField(const Options&)>;

/// A kind of surface: adds the options that it alone has.
struct Kind {
  const char* name;
  const char* description;
  const char* example;
  enum class Periodic { Offered, Impossible } periodic;
  Make (*add)(CLI::App& app);
};

Make add_gaussian(CLI::App& app) {
  struct Own {
    GaussianField field;
    double tau = 3;
  };
  auto own = std::make_shared<Own>();
  add_length(app, "--rms", own->field.rms, "Root mean square height (default 0.3 µm)");
  auto* tau =
      add_length(app, "--tau", own->tau, "Correlation length, the same in all directions (default 3 µm)");
  auto* tau_x =
      add_length(app, "--tau-x", own->field.tau_x, "Correlation length along the orientation")->excludes(tau);
  auto* tau_y = add_length(app, "--tau-y", own->field.tau_y, "Correlation length across the orientation")
                    ->excludes(tau);
  tau_x->needs(tau_y);
  tau_y->needs(tau_x);
  add_angle(app, "--orientation", own->field.orientation,
            "Direction of tau-x, from +x towards +y (default 0)")
      ->needs(tau_x);
  return [own, tau_x](const Options& options) {
    if (tau_x->count() == 0) own->field.tau_x = own->field.tau_y = own->tau;
    return gaussian_surface(options.grid, own->field, options.seed, options.border);
  };
}

Make add_multiscale(CLI::App& app) {
  auto law = std::make_shared<PowerLaw>();
  add_length(app, "--rms", law->rms, "Root mean square height of the sum (default 0.3 µm)");
  add_length(app, "--tau-min", law->tau_min, "Shortest correlation length (default 0.3 µm)");
  add_length(app, "--tau-max", law->tau_max, "Longest correlation length (default 30 µm)");
  app.add_option("--scales", law->count, "How many correlation lengths, in geometric progression (default 8)")
      ->check(CLI::Range(1, 1000));
  app.add_option("--hurst", law->hurst,
                 "Amplitudes grow as the correlation length to this power (default 0.7)");
  app.add_option("--aspect", law->aspect,
                 "Correlation length along the orientation over that across it (default 1)");
  add_angle(app, "--orientation", law->orientation,
            "Direction of the long correlation, from +x towards +y (default 0)");
  return [law](const Options& options) {
    return multiscale_surface(options.grid, power_law_scales(*law), options.seed, options.border);
  };
}

Make add_brushed(CLI::App& app) {
  auto brushing = std::make_shared<Brushing>();
  add_length(app, "--rms", brushing->rms, "Root mean square height (default 0.1 µm)");
  add_length(app, "--length", brushing->length, "Mean length of a scratch (default 50 µm)");
  add_length(app, "--width", brushing->width, "Mean width of a scratch (default 1.5 µm)");
  app.add_option("--coverage", brushing->coverage, "Mean number of scratches over a point (default 10)");
  add_angle(app, "--spread", brushing->spread,
            "Scratches deviate from the orientation by up to this angle (default 0.02rad)");
  add_angle(app, "--orientation", brushing->orientation,
            "Direction of the brushing, from +x towards +y (default 0)");
  return [brushing](const Options& options) {
    return brushed_surface(options.grid, *brushing, options.seed, options.border);
  };
}

/// What rises at an angle. Throws InputError if that is upright or more.
double slope_of(double angle, const std::string& option) {
  if (!(std::abs(angle) < std::numbers::pi / 2))
    throw InputError(option + ": a surface of one height over each point is less than 90 degrees steep");
  return std::tan(angle);
}

std::shared_ptr<Grating> add_grating(CLI::App& app) {
  auto grating = std::make_shared<Grating>();
  add_length(app, "--period", grating->period, "Period (default 4 µm)");
  add_angle(app, "--orientation", grating->orientation,
            "Direction of the wave vector, from +x towards +y (default 0)");
  return grating;
}

CLI::Option* add_depth(CLI::App& app, Grating& grating) {
  return add_length(app, "--depth", grating.depth, "Peak to valley (default 0.2 µm)");
}

Make add_sinusoid(CLI::App& app) {
  auto grating = add_grating(app);
  add_depth(app, *grating);
  return
      [grating](const Options& options) { return sinusoid_surface(options.grid, *grating, options.border); };
}

Make add_blazed(CLI::App& app) {
  auto grating = add_grating(app);
  auto* depth = add_depth(app, *grating);
  auto blaze = std::make_shared<double>(0);
  auto* angle = add_angle(app, "--blaze", *blaze, "Blaze angle, instead of a depth")->excludes(depth);
  return [grating, blaze, angle](const Options& options) {
    if (angle->count() > 0) grating->depth = grating->period * slope_of(*blaze, "--blaze");
    return blazed_surface(options.grid, *grating, options.border);
  };
}

Make add_two_level(CLI::App& app) {
  auto grating = add_grating(app);
  add_depth(app, *grating);
  auto duty = std::make_shared<double>(0.5);
  app.add_option("--duty", *duty, "Fraction of the period that is high (default 0.5)");
  return [grating, duty](const Options& options) {
    return two_level_surface(options.grid, *grating, *duty, options.border);
  };
}

struct Tilt {
  double x = 0, y = 0;  ///< radians
  double slope_x() const { return slope_of(x, "--tilt-x"); }
  double slope_y() const { return slope_of(y, "--tilt-y"); }
};

std::shared_ptr<Tilt> add_tilt(CLI::App& app) {
  auto tilt = std::make_shared<Tilt>();
  add_angle(app, "--tilt-x", tilt->x, "Angle whose tangent is the slope along x (default 0)");
  add_angle(app, "--tilt-y", tilt->y, "Angle whose tangent is the slope along y (default 0)");
  return tilt;
}

Make add_plane(CLI::App& app) {
  auto tilt = add_tilt(app);
  return [tilt](const Options& options) {
    return plane_surface(options.grid, tilt->slope_x(), tilt->slope_y());
  };
}

Make add_facet(CLI::App& app) {
  auto tilt = add_tilt(app);
  auto side = std::make_shared<double>(10);
  add_length(app, "--side", *side, "Side of the square facet (default 10 µm)");
  return [tilt, side](const Options& options) {
    return facet_surface(options.grid, *side, tilt->slope_x(), tilt->slope_y());
  };
}

Make add_step(CLI::App& app) {
  struct Own {
    double height = 1, orientation = 0;
  };
  auto own = std::make_shared<Own>();
  add_length(app, "--height", own->height, "Height of the step (default 1 µm)");
  add_angle(app, "--orientation", own->orientation,
            "Direction in which it goes up, from +x towards +y (default 0)");
  return [own](const Options& options) { return step_surface(options.grid, own->height, own->orientation); };
}

using Periodic = Kind::Periodic;
constexpr std::array kKinds = {
    Kind{"gaussian", "Gaussian random field of one correlation length", "--rms 0.3um --tau 3um -o rough.dat",
         Periodic::Offered, add_gaussian},
    Kind{"multiscale", "Sum of Gaussian fields over many correlation lengths, like real metal",
         "--tau-min 300nm --tau-max 30um -o metal.h5", Periodic::Offered, add_multiscale},
    Kind{"brushed", "Long random scratches", "--length 50um --width 1.5um --orientation 90deg -o brushed.dat",
         Periodic::Offered, add_brushed},
    Kind{"sinusoid", "Sinusoidal grating", "--period 4um --depth 200nm -o sine.dat", Periodic::Offered,
         add_sinusoid},
    Kind{"blazed", "Blazed grating", "--period 4um --blaze 5deg -o blazed.dat", Periodic::Offered,
         add_blazed},
    Kind{"two-level", "Two-level grating", "--period 4um --duty 0.3 -o lamellar.dat", Periodic::Offered,
         add_two_level},
    Kind{"plane", "Tilted plane", "--tilt-x 5deg -o plane.dat", Periodic::Impossible, add_plane},
    Kind{"step", "Step through the middle", "--height 1um -o step.dat", Periodic::Impossible, add_step},
    Kind{"facet", "Single tilted square, all missing around it", "--side 10um --tilt-x 5deg -o facet.dat",
         Periodic::Impossible, add_facet},
};

void add_shared_options(CLI::App& app, Options& options, const Kind& kind) {
  app.add_option("-o,--output", options.output,
                 std::string("File to write; its suffix ") + kScanSuffixes + " says the format")
      ->required()
      ->type_name("FILE");
  app.add_option("--rows", options.grid.rows, "Points along y (default 480)");
  app.add_option("--cols", options.grid.cols, "Points along x (default 640)");
  add_pitch(app, options.pitch, "Distance between points, P or X,Y (default 0.11 µm)");
  app.add_option("--seed", options.seed, "Seed of everything random (default 1)")->check(seed_number());
  if (kind.periodic == Periodic::Offered)
    app.add_flag_callback(
        "--periodic", [&options] { options.border = Border::Periodic; }, "Continue at the opposite border");
  app.add_option("--holes", options.holes.fraction, "Expected fraction of missing points (default 0)");
  add_length(app, "--hole-radius", options.holes.radius, "Radius of round holes (default 0: single points)");
}

/// Throws CLI::ValidationError if the options make no surface.
HeightField surface_of(const Options& options, const Make& make) {
  try {
    return make_holes(make(options), options.holes, options.seed);
  } catch (const InputError& error) {
    throw CLI::ValidationError(error.what());
  }
}

int synth(Options& options, const Kind& kind, const Make& make, const CLI::App& app) {
  const ScanTarget& target = scan_target_of(options.output);
  const ReadOptions pitch = parse_pitch(options.pitch);
  options.grid.dx = pitch.pitch_x.value_or(options.grid.dx);
  options.grid.dy = pitch.pitch_y.value_or(pitch.pitch_x.value_or(options.grid.dy));
  const HeightField surface = surface_of(options, make);
  target.write(options.output, surface, command_line_of(app));
  print_written(options.common, {{"kind", kind.name}, {"seed", options.seed}}, kind.name, options.output,
                target, surface);
  return kDone;
}

}  // namespace

Run add_synth(CLI::App& app) {
  app.require_subcommand(1);
  auto chosen = std::make_shared<Run>();
  for (const Kind& kind : kKinds) {
    CLI::App* subcommand = app.add_subcommand(kind.name, kind.description);
    auto options = std::make_shared<Options>();
    const Make make = kind.add(*subcommand);
    add_shared_options(*subcommand, *options, kind);
    const std::string example = std::string("microbrdf synth ") + kind.name + " " + kind.example;
    add_common_options(*subcommand, options->common, example.c_str());
    subcommand->final_callback([chosen, options, make, subcommand, &kind] {
      *chosen = [options, make, subcommand, &kind] { return synth(*options, kind, make, *subcommand); };
    });
  }
  app.footer(std::string("Example:\n  microbrdf synth gaussian --rms 0.3um --tau 3um -o rough.dat\n") +
             kExitCodes);
  return [chosen] { return (*chosen)(); };
}

}  // namespace micro::tools
