#include "app/output/render_work.h"
#include "tools/patinate/command_line/times_argument.h"
#include "tools/patinate/commands/command_words.h"
#include "tools/patinate/commands/commands.h"
#include "tools/patinate/commands/output_command.h"

namespace patinate::cli {

namespace {

void declare_views(CommandLine& line, app::ViewChoice& choice) {
  line.option("views", "LIST",
              "Several pictures: front, left, back, right, top, bottom or AZIMUTH:ELEVATION, separated by commas",
              choice.views);
  line.option("turntable", "N", "N pictures evenly around the up axis, from --azimuth on", choice.turntable);
  line.alternatives({"views", "turntable"});
  line.numbers("target", "X,Y,Z",
               "What the camera looks at, in the mesh's unit (mm of a transfer or simulation); default: its middle",
               choice.target);
  line.option("distance", "LENGTH", "From the camera to the target; default: so that the mesh fits", choice.distance);
}

void declare_maps(CommandLine& line, app::SurfaceFiles& files) {
  for (const app::SurfaceFiles::Named& f : app::SurfaceFiles::named())
    line.option(f.name, "IMAGE", f.help, files.*f.file);
}

}  // namespace

int cmd_render(CommandRun& run) {
  app::RenderTask task;
  device::DeviceOptions device;
  TimesArgument times;
  run.line.positional("SUBJECT", "A transfer, a simulation, a history, or a mesh with --texture", task.subject);
  run.line.output("PICTURE",
                  "Image to make: .png, .jpg, .tif or .exr; of a transfer or simulation also a movie (.mp4, .webm, "
                  ".gif) or images aged_%04d.png",
                  task.output);
  times.declare(run.line);
  declare_maps(run.line, task.files);
  run.line.option("unit", "um|mm|cm|m", "Unit of a mesh whose --height-map is given; default: m for glTF, else mm",
                  task.unit);
  run.line.option("environment", "IMAGE", "Environment map that lights the object: 360 x 180 degrees, HDR or EXR",
                  task.environment);
  declare_views(run.line, task.views);
  run.line.options(task.shown);
  run.line.options(task.surface);
  run.line.options(task.options);
  run.line.options(task.movie);
  run.line.options(task.turn);
  run.line.options(device);
  run.line.checked([&] { app::check_task(task); });
  run.line.usual({"time", "times", "num_times", "width", "height", "turntable"});
  run.line.example("render rain -o rain.png");
  run.line.example("render rain --views front,left,40:20 --environment sky.hdr -o rain.png");
  run.line.example("render rain --turntable 90 -o rain.mp4");
  run.line.example("render aged_bust --time 12 -o bust.png");
  run.line.example("render aged_bust --num-times 5 -o strip.png");
  run.line.example("render aged_bust --frames 150 --turn 360 -o bust.mp4");
  run.line.example("render bust.glb --texture albedo.png -o bust.png");
  if (!run.parse()) return 0;
  task.times = times;
  task.is_width_given = run.line.is_given("width");
  task.is_height_given = run.line.is_given("height");
  task.devices = app::output_devices(device, words_of(run));
  return run_output(run, app::render_work(std::move(task)));
}

}  // namespace patinate::cli
