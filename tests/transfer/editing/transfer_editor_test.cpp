#include "transfer/editing/transfer_editor.h"

#include <gtest/gtest.h>

#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>

#include "patinate/atlas/direction_field.h"
#include "tests/support/errors.h"
#include "tests/support/histories.h"
#include "tests/support/meshes.h"
#include "tests/support/temp_folder.h"
#include "transfer/job/transfer_job.h"

namespace patinate::transfer {
namespace {

namespace fs = std::filesystem;
using testing_support::error_of;
using testing_support::has;
using testing_support::TempFolder;

constexpr int kSide = 64;  // Texels.

TransferEdit stroke(double x, double y, double value) {
  return {.kind = EditKind::Stroke,
          .control = "x",
          .value = value,
          .stroke = {.points_mm = {{x, y, 0.0}, {x + 6.0, y, 0.0}}, .radius_mm = 9.0, .flow = 0.8}};
}

TransferEdit refinement() {
  TransferEdit edit;
  edit.kind = EditKind::Refine;
  return edit;
}

class EditedTransfer : public testing::Test {
 protected:
  void SetUp() override {
    fs::create_directory(folder_ / "history");
    testing_support::write_history(folder_ / "history", 64, 64, 2, testing_support::blotches);
    task_.history = std::make_shared<const HistoryReader>(folder_ / "history");
    task_.input.map = std::make_shared<TexelMap>(testing_support::cut_plane(kSide), kSide, kSide);
    task_.mesh_name = "plane.obj";
    task_.input.texel_size_mm = task_.input.map->median_texel_size_mm();
    task_.input.frames = std::make_shared<const FlowFrames>(
        direction_frames(*task_.input.map, DirectionKind::Gravity, Vec3(0.3, 1.0, 0.0)));
    task_.flow = "gravity";
    ImageF guide(kSide, kSide);
    for (int i = 0; i < kSide * kSide; ++i) guide.data()[i] = static_cast<float>(i % kSide) / (kSide - 1.0f);
    task_.input.controls.push_back({"x", "image", guide, {}, 1.0, ControlMapping::Rank});
  }
  fs::path made(const std::string& name, const TransferEdits& edits) {
    EXPECT_EQ(run_job(plan_transfer(task_, folder_ / name, edits), {}, {}), JobStatus::Done);
    return folder_ / name;
  }
  static std::string bytes(const fs::path& folder, const char* file) {
    std::ifstream stream(folder / file, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
  }

  TempFolder folder_;
  TransferTask task_;
  TransferEdits edits_{{stroke(12, 20, 0.9), stroke(30, 40, 0.1), refinement(), stroke(14, 22, 0.2)}};
};

TEST_F(EditedTransfer, GivesTheSameBytesAtOnceAndOneByOneAndInTwoSittings) {
  const fs::path at_once = made("at_once", edits_), one_by_one = made("one_by_one", {}),
                 again = made("again", {{edits_.edits[0], edits_.edits[1]}});
  {
    TransferEditor editor(one_by_one);
    for (const TransferEdit& edit : edits_.edits) (void)editor.apply(edit);
    editor.write();
    TransferEditor later(again);
    EXPECT_EQ(later.edits().edits.size(), 2u);
    (void)later.apply(edits_.edits[2]);
    (void)later.apply(edits_.edits[3]);
    later.write();
  }
  for (const fs::path& folder : {one_by_one, again}) {
    EXPECT_EQ(bytes(at_once, "edits.json"), bytes(folder, "edits.json")) << folder;
    EXPECT_EQ(bytes(at_once, "coordinates.exr"), bytes(folder, "coordinates.exr")) << folder;
    EXPECT_EQ(load_json(at_once / "transfer.json")["energy"], load_json(folder / "transfer.json")["energy"]) << folder;
  }
}

TEST_F(EditedTransfer, LeavesEverythingElseAsItWas) {
  const fs::path folder = made("plain", {});
  TransferEditor editor(folder);
  const std::span<const TexelId> changed = editor.apply(edits_.edits[0]);
  const TexelSet region(editor.map().num_texels(), changed);
  editor.write();
  EXPECT_LT(region.size(), std::size_t{kSide} * kSide / 3);
  const TransferReader after(folder);
  std::size_t num_moved = 0;
  for (TexelId t = 0; t < editor.map().num_texels(); ++t) {
    const float *was = editor.reader().coordinates().data() + 2 * t, *is = after.coordinates().data() + 2 * t;
    const bool is_same = was[0] == is[0] && was[1] == is[1];
    num_moved += is_same ? 0 : 1;
    EXPECT_TRUE(is_same || region.contains(t)) << t;
  }
  EXPECT_GT(num_moved, 50u);
}

TEST_F(EditedTransfer, UndoAndRedoGiveEveryPlaceBack) {
  TransferEditor editor(made("plain", {}));
  const auto places = [&] {
    std::vector<std::array<int, 4>> all;
    for (TexelId t = 0; t < editor.map().num_texels(); ++t) {
      const SourcePlace p = editor.place(t);
      all.push_back({p.pixel, p.beside_x, p.beside_y, static_cast<int>(4095.0 * editor.wanted(0, t))});
    }
    return all;
  };
  std::vector<std::vector<std::array<int, 4>>> after{places()};
  for (const TransferEdit& edit : edits_.edits) {
    (void)editor.apply(edit);
    after.push_back(places());
  }
  for (std::size_t n = edits_.edits.size(); n-- > 0;) {
    EXPECT_FALSE(editor.undo().empty());
    EXPECT_EQ(places(), after[n]) << n;
  }
  EXPECT_TRUE(editor.undo().empty());
  for (std::size_t n = 1; n <= edits_.edits.size(); ++n) {
    EXPECT_FALSE(editor.redo().empty());
    EXPECT_EQ(places(), after[n]) << n;
  }
  // What comes behind an undone edit is as if that had never been.
  (void)editor.undo();
  (void)editor.undo();
  (void)editor.apply(edits_.edits[2]);
  EXPECT_EQ(places(), after[3]);
  EXPECT_EQ(editor.num_redoable(), 0u);
}

TEST_F(EditedTransfer, SaysWhatItWasAskedToFollow) {
  const fs::path folder = made("painted", {{edits_.edits[0]}});
  const ImageF asked = TransferReader(folder).matched_control(0);
  const TransferEditor editor(folder);
  for (TexelId t = 0; t < editor.map().num_texels(); ++t) {
    // Controls are compared in kControlSteps steps, once before and once after the stroke.
    if (!editor.map().is_covered(t)) continue;
    ASSERT_NEAR(asked.data()[t], editor.wanted(0, t), 1.0 / kControlSteps) << t;
  }
}

TEST_F(EditedTransfer, RefusesWhatCannotBeDone) {
  TransferEdit unknown = edits_.edits[1];
  unknown.control = "z";
  EXPECT_TRUE(has(error_of<InvalidInput>([&] {
                    (void)plan_transfer(task_, folder_ / "bad", {{edits_.edits[0], unknown}});
                  }),
                  "edit 2: control `z` is none that the transfer follows; expected x"));
  TransferEditor editor(made("plain", {}));
  EXPECT_TRUE(
      has(error_of<InvalidInput>([&] { (void)editor.apply(stroke(500, 500, 0.5)); }), "a stroke reaches no texel"));
  EXPECT_TRUE(has(error_of<InvalidInput>([&] { (void)editor.apply(refinement()); }), "there is nothing to refine"));
  EXPECT_EQ(editor.num_undoable(), 0u);
}

TEST_F(EditedTransfer, ReadsOnlyWhatAFileOfEditsMayHold) {
  write_transfer_edits(folder_ / "edits.json", edits_);
  EXPECT_EQ(edits_json(read_transfer_edits(folder_ / "edits.json")), edits_json(edits_));
  const auto read = [&](const char* member, const Json& value) {
    Json json = edits_json(edits_);
    json["edits"][0][member] = value;
    return edits_from_json(json, "edits.json");
  };
  EXPECT_TRUE(has(error_of<IoError>([&] { (void)read("value", 1.5); }), "/edits/0/value"));
  EXPECT_TRUE(has(error_of<IoError>([&] { (void)read("flow", 0.0); }), "/edits/0/flow"));
  EXPECT_TRUE(has(error_of<IoError>([&] { (void)read("radius_mm", -1); }), "/edits/0/radius_mm"));
  EXPECT_TRUE(has(error_of<IoError>([&] { (void)read("points_mm", Json::array()); }), "/edits/0/points_mm"));
  EXPECT_TRUE(has(error_of<IoError>([&] { (void)read("kind", "erase"); }), "/edits/0/kind"));
  EXPECT_TRUE(has(error_of<IoError>([&] { (void)read("size", 1); }), "size"));
}

}  // namespace
}  // namespace patinate::transfer
