// demo_page FOLDER: writes the page that shows what tools/demo has made there.
#include <cstdio>
#include <exception>
#include <filesystem>
#include <string>
#include <vector>

#include "libcommon/core/text.h"
#include "libcommon/output/html_page.h"

namespace {

using patinate::HtmlPage;
using patinate::HtmlPicture;

void add_control(HtmlPage& page, const std::string& control, const std::string& where) {
  page.heading("Paint that is thick " + where);
  page.picture({"pictures/control_" + control + ".png", "The control map: thick paint is white."});
  std::vector<HtmlPicture> frames;
  for (const char* time : {"0", "22.5", "45", "67.5", "90", "120", "172.5"}) {  // Times as tools/demo renders them.
    const std::string number = patinate::zero_padded(frames.size(), 4);
    frames.push_back({"pictures/" + control + "_" + number + ".png", std::string(time) + " s"});
  }
  page.time_slider(frames, "Move the slider to age the urn.");
  page.picture({"pictures/strip_" + control + ".png", "Four ages under the same light."});
  page.link("urn_" + control + ".glb", "urn_" + control + ".glb: the mesh with five ages (KHR_materials_variants)");
}

void write_page(const std::filesystem::path& folder) {
  HtmlPage page("Crackled paint on an urn");
  page.paragraph(
      "A painted plate was photographed while its paint dried and cracked, and once on a back-light, which shows how "
      "thick "
      "the paint is. patinate made a material history of it, and aged an urn with it: where the urn's paint is thick, "
      "its "
      "cracks are those of thick paint. Photographs and urn are synthetic, so that this demo needs no data.");
  page.frame("urn.html",
             "Turn the urn, move the time. Color by: where it comes from shows which part of the plate each place is.");
  page.heading("The material history");
  page.picture({"pictures/history.png", "The plate at four times."});
  add_control(page, "facing", "on what faces up");
  add_control(page, "spray", "where a nozzle has sprayed it");
  page.heading("The same with your own photographs");
  page.paragraph("Put them into a folder of their own, then:");
  page.code(
      "patinate init photos\n"
      "patinate ingest photos/capture.json -o history\n"
      "patinate transfer history object.obj --control accessibility -o aged\n"
      "patinate export aged --num-times 5 -o aged.glb");
  page.save(folder / "index.html");
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: demo_page FOLDER\n");
    return 2;
  }
  try {
    write_page(argv[1]);
    return 0;
  } catch (const std::exception& e) {
    std::fprintf(stderr, "demo_page: error: %s\n", e.what());
    return 1;
  }
}
