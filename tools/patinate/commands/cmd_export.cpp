#include "app/output/export_work.h"
#include "tools/patinate/command_line/times_argument.h"
#include "tools/patinate/commands/command_words.h"
#include "tools/patinate/commands/commands.h"
#include "tools/patinate/commands/output_command.h"

namespace patinate::cli {

int cmd_export(CommandRun& run) {
  app::ExportTask task;
  device::DeviceOptions device;
  TimesArgument times;
  run.line.positional("SUBJECT", "A transfer or simulation, or for pictures a history", task.subject);
  run.line.output(
      "OUTPUT",
      "MODEL.glb with one variant a time; MODEL.usdz or .usda with textures over time; MODEL.obj with MTL at one "
      "time; .usda and .obj with MaterialX; MOVIE.mp4, .webm or .gif; images aged_%04d.png; or a folder of images",
      task.output);
  times.declare(run.line);
  run.line.options(task.format);
  run.line.options(task.movie);
  run.line.options(task.axis);
  run.line.options(task.flakes);
  run.line.options(device);
  run.line.checked([&] { app::check_output(task); });
  run.line.example("export aged_bust -o bust.glb --times 0,6,12");
  run.line.example("export aged_bust -o bust.usdz --num-times 20");
  run.line.example("export aged_bust -o bust.obj --time 12");
  run.line.example("export aged_scan -o scan.glb --up z");
  run.line.example("export aged_bust -o textures --format png");
  run.line.example("export copper -o copper.mp4 --frames 200 --fps 25");
  if (!run.parse()) return 0;
  task.times = times;
  task.devices = app::output_devices(device, words_of(run));
  return run_output(run, app::export_work(task));
}

}  // namespace patinate::cli
