/// \file
/// An aging mesh as a model: GLB, USD, or OBJ with MTL.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "app/output/export_work.h"

namespace patinate::app {

enum class ModelFormat { Glb, Usd, Obj };

/// Format of a model, by its name; nothing if it is none.
[[nodiscard]] std::optional<ModelFormat> model_format(const std::filesystem::path& path);
/// @param task  Of a transfer or simulation. @throws UsageError, IoError
[[nodiscard]] OutputWork model_work(const ExportTask& task, ModelFormat format);

}  // namespace patinate::app
