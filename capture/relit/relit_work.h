/// \file
/// What the steps of a relit ingest share. Inside of ingest only.
#pragma once

#include <array>
#include <filesystem>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "capture/relit/relit_ingest.h"
#include "capture/relit/relit_view.h"
#include "patinate/capture/unlight.h"
#include "patinate/core/json.h"
#include "patinate/geometry/point_cloud.h"

namespace patinate::capture {

/// Result of relit_reference.cpp that every step needs.
struct RelitReference {
  ScanView view;                   ///< Nothing seen when the project has no shape.
  std::vector<Vec3> patch_target;  ///< One a light: what the patch should show; empty without a patch.
  bool is_patch_absolute =
      false;  ///< The target follows from the patch's albedo; else it is what the reference step shows.
};

/// Registration of a step's scan.
struct RelitRegistration {
  double rms_mm = 0.0;
  double overlap = 0.0;
  int num_pairs = 0;
  bool is_found_by_search = false;
  double stddev_deg = 0.0,
         stddev_mm = 0.0;      ///< Deviation of the pose, as far as the surface that stayed may be misjudged, too.
  double staying = 1.0;        ///< Share of the surface that lies where the reference's does.
  double ambiguous_deg = 0.0;  ///< Degrees by which another pose turns that fits nearly as well; 0 = none.
  std::vector<std::string> unconstrained_dofs = {};  ///< Unconstrained dofs as text_of() says them.
};

/// How a step's scan lies in the reference's frame.
struct RelitPose {
  /// Status of a pose that fits, but most of the surface has changed since the reference: good enough for colors, whose
  /// places move by less than the surface, and none for heights.
  static constexpr std::string_view kMisled = "surface has changed";

  std::string
      status;  ///< "reference", "given", "given by a registration", RelitPose::kMisled, or what registration says.
  bool is_accepted = true;
  RigidTransform reference_from_scan;
  std::optional<RelitRegistration> registration = {};  ///< Where it was registered.
  bool is_joint = false;  ///< Solved for together with other steps; else with the reference alone.
};

/// State of a lamp's samples: shares of the surface by SampleState; Outside is not counted.
struct RelitLight {
  std::array<double, kNumSampleStates> shares = {};
  double residual = 0.0;
};

/// Solution of a step's photographs.
struct RelitSolution {
  std::vector<RelitLight> lights = {};
  double residual = 0.0;
  double noise_scale = 0.0;
  std::vector<std::string> notes = {};
};

/// The frame of a step that is in the history.
struct RelitFrame {
  std::optional<double> overlap = {},
                        offset_mm = {};        ///< How its scan lies on the reference's; of a project with a shape.
  std::vector<Vec3> gains = {};                ///< By the patch, a photograph each.
  std::optional<RelitSolution> solution = {};  ///< Nothing of ready-made albedo.
  double seen_share = 0.0, determined_share = 0.0;
};

/// Everything that is said of a step.
struct RelitStepFacts {
  int step = 0;
  double time = 0.0;
  RelitPose pose;
  std::optional<RelitFrame> frame = {};  ///< None: the step is excluded from the history.
};
/// Facts as relit.json and the files of the steps have them.
[[nodiscard]] Json to_json(const RelitStepFacts& facts);
/// The inverse; of files of our own only.
[[nodiscard]] RelitStepFacts relit_step_facts(const Json& json);
/// Facts of a pose alone.
[[nodiscard]] Json to_json(const RelitPose& pose);
[[nodiscard]] RelitPose relit_pose(const Json& json);

struct RelitWork {
  RelitWork(RelitProject the_project, RelitOptions the_options)
      : project(std::move(the_project)), options(the_options) {}

  RelitProject project;
  RelitOptions options;
  std::vector<std::string> step_keys = {};  ///< Content of every step's files.
  std::string key = "";

  /// The history without frames and controls.
  [[nodiscard]] HistoryManifest manifest() const;
  /// "steps/2", for errors and reports.
  [[nodiscard]] std::string step_name(std::size_t index) const;
  /// The reference and the steps whose poses are solved for together; none where they are fewer than three.
  [[nodiscard]] std::vector<std::size_t> joint_steps() const;
  /// Loaded once a run from what the reference item has written.
  [[nodiscard]] const RelitReference& reference(const std::filesystem::path& folder) const;

 private:
  mutable std::mutex mutex_;
  mutable std::optional<RelitReference> reference_;
};

// Files of the finished history that are of no use to its readers: what a later run with more steps resumes from, and
// pictures.
[[nodiscard]] std::filesystem::path relit_reference_file();
[[nodiscard]] std::filesystem::path relit_curvature_file();
[[nodiscard]] std::filesystem::path relit_pose_file(std::size_t index);
[[nodiscard]] std::filesystem::path relit_validity_file(std::size_t index);
[[nodiscard]] std::filesystem::path relit_facts_file(std::size_t index);
/// report/albedo_0003.png. @param what  "albedo", "light", "samples" or "stddev".
[[nodiscard]] std::filesystem::path relit_picture_file(const std::string& what, std::size_t index);

/// A step's scan in mm, or the surface of its ready-made maps; its mesh with normals. @throws IoError naming the file.
[[nodiscard]] PointCloud read_step_scan(const RelitProject& project, const RelitStep& step);
[[nodiscard]] Mesh read_step_mesh(const RelitProject& project, const RelitStep& step);

/// A step's photographs, linear.
struct StepPhoto {
  ImageF values;            ///< H x W x 3, the ambient light not subtracted.
  float saturation = 0.0f;  ///< Value from which on a channel is saturated.
};
[[nodiscard]] StepPhoto read_step_photo(const RelitProject& project, const std::filesystem::path& file);
/// The ambient light's photograph; zeros without one.
[[nodiscard]] ImageF read_step_ambient(const RelitProject& project, const RelitStep& step);
/// photo - ambient.
void subtract_ambient(ImageF& photo, const ImageF& ambient);

/// Mean over the patch's pixels. @throws IoError naming the photograph if it is saturated or black there.
[[nodiscard]] Vec3 patch_mean(const RelitProject& project, const StepPhoto& photo, const ImageF& ambient,
                              const std::filesystem::path& file);
/// Finds the patch in the reference step's photographs, and what it should show. @param view  Of the reference.
void find_patch_target(const RelitProject& project, RelitReference& reference);

/// Stage 0: the reference view, its curvature, the patch.
void run_relit_reference(const RelitWork& work, const std::filesystem::path& folder, const RunControl& control);
/// Stage 1: the pose of one step.
void run_relit_pose(const RelitWork& work, std::size_t index, const std::filesystem::path& folder,
                    const RunControl& control);
/// The poses of all joint_steps() but the reference's.
void run_relit_joint_poses(const RelitWork& work, const std::filesystem::path& folder, const RunControl& control);
/// The pose as it is, if it is accepted or may be left out. @throws CannotComplete
void check_relit_pose(const RelitWork& work, std::size_t index, const RelitPose& pose);
[[nodiscard]] RelitPose read_relit_pose(std::size_t index, const std::filesystem::path& folder);
/// Stage 2: the frame of one step, with its mask, its extras, its facts and its pictures.
void run_relit_step(const RelitWork& work, std::size_t index, const std::filesystem::path& folder,
                    const RunControl& control);
/// How much higher the step's scan stands than the reference's, along the reference's normal, mm, as `height-change`
/// measures it (measure_relief(): where a transform of the project has it, else by the surface that stays): H x W, 0 in
/// the reference and where either has no surface.
/// @throws CannotComplete where the scans share too little to be laid over one another.
[[nodiscard]] ImageF relit_height(const RelitWork& work, std::size_t index, const RelitPose& pose,
                                  const ScanView& reference, const RunControl& control);
/// Files that run_relit_step() writes beside its facts, of a step that is in the history (--accept-failed leaves some
/// out).
[[nodiscard]] std::vector<std::filesystem::path> relit_frame_outputs(const RelitWork& work, std::size_t index);
[[nodiscard]] std::vector<std::string> relit_frame_extras(const RelitWork& work);
/// The page and relit.json. @param history  All of it but for the manifest's file is written. @param mask  The
/// history's.
void write_relit_report(const HistoryManifest& history, const RelitWork& work, const std::filesystem::path& folder,
                        const std::vector<RelitStepFacts>& facts, const ImageU8& mask, const RunControl& control);

}  // namespace patinate::capture
