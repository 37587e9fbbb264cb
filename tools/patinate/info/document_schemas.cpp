#include "tools/patinate/info/document_schemas.h"

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

#include "analysis/report/analysis_documents.h"
#include "capture/unlighting/unlit_document.h"
#include "libcommon/core/text.h"
#include "libcommon/history/history_documents.h"
#include "patinate/core/error.h"
#include "simulation/job/simulation_job.h"
#include "tools/patinate/command_line/plan_file.h"
#include "transfer/files/transfer_edits.h"
#include "transfer/files/transfer_files.h"

namespace patinate::cli {

namespace {

struct NamedSchema {
  const char* name;
  Json (*make)();
};
constexpr std::array kSchemas{NamedSchema{"card", history_card_schema},
                              NamedSchema{"compare", analysis::compare_schema},
                              NamedSchema{"edits", transfer::edits_schema},
                              NamedSchema{"evaluation", analysis::evaluation_schema},
                              NamedSchema{"explanation", analysis::explanation_schema},
                              NamedSchema{"factorization", analysis::factorization_schema},
                              NamedSchema{"field", analysis::field_schema},
                              NamedSchema{"fit", analysis::fit_schema},
                              NamedSchema{"grade", analysis::grade_schema},
                              NamedSchema{"grade_groups", analysis::grade_groups_schema},
                              NamedSchema{"history", history_schema},
                              NamedSchema{"plan", plan_schema},
                              NamedSchema{"ranking", analysis::ranking_schema},
                              NamedSchema{"replicates", analysis::replicates_schema},
                              NamedSchema{"simulation", simulation::simulation_schema},
                              NamedSchema{"transfer", transfer::transfer_schema},
                              NamedSchema{"unlit", capture::unlit_schema}};

}  // namespace

std::vector<std::string> schema_names() {
  std::vector<std::string> names;
  for (const NamedSchema& schema : kSchemas) names.emplace_back(schema.name);
  return names;
}

Json schema_of(const std::string& name) {
  const auto* const found =
      std::find_if(kSchemas.begin(), kSchemas.end(), [&](const NamedSchema& s) { return s.name == name; });
  if (found != kSchemas.end()) return found->make();
  std::string list;
  for (const NamedSchema& schema : kSchemas) list += (list.empty() ? "" : ", ") + std::string(schema.name);
  throw InvalidInput("schema: found `" + name + "`; expected " + list + did_you_mean(name, schema_names()));
}

}  // namespace patinate::cli
