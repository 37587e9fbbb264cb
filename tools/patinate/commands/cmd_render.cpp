#include "tools/patinate/command_line/times_argument.h"
#include "tools/patinate/commands/commands.h"
#include "tools/patinate/services/device_words.h"
#include "tools/patinate/services/output_command.h"
#include "tools/patinate/services/render_work.h"

namespace patinate::cli {

int cmd_render(CommandRun& run) {
  RenderTask task;
  device::DeviceOptions device;
  TimesArgument times;
  run.line.positional("SUBJECT", "A transfer, a simulation, a history, or a mesh with --texture", task.subject);
  run.line.output("PICTURE",
                  "Image to make: .png, .jpg, .tif or .exr; of a transfer or simulation also a movie (.mp4, .webm, "
                  ".gif) or images aged_%04d.png",
                  task.output);
  times.declare(run.line);
  task.files.declare(run.line);
  run.line.option("unit", "um|mm|cm|m", "Unit of a mesh whose --height-map is given; default: m for glTF, else mm",
                  task.unit);
  run.line.option("environment", "IMAGE",
                  "Surroundings that light the object: a picture of 360 x 180 degrees, HDR or EXR", task.environment);
  task.views.declare(run.line);
  run.line.options(task.shown);
  run.line.options(task.surface);
  run.line.options(task.options);
  run.line.options(task.movie);
  run.line.options(task.turn);
  run.line.options(device);
  run.line.checked([&] { check_task(task); });
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
  task.devices = output_devices(device, words_of(run));
  return run_output(run, render_work(std::move(task)));
}

}  // namespace patinate::cli
