#include "capture/project/sample_facts.h"

#include "libcommon/core/text.h"

namespace patinate::capture {

std::vector<SampleFact> read_sample(JsonReader& project) {
  std::vector<SampleFact> sample;
  if (!project.has("sample")) return sample;
  JsonReader json = project.member("sample");
  const std::vector<std::string> names = json.keys();
  if (names.size() > kMaxSampleFacts) json.fail("at most " + std::to_string(kMaxSampleFacts) + " texts or numbers");
  for (const std::string& name : names) {
    const JsonReader value = json.member(name);
    sample.push_back({name, value.is_number() ? number_text(value.number()) : value.string()});
  }
  return sample;
}

std::string sample_text(const std::vector<SampleFact>& sample) {
  std::string text;
  for (const SampleFact& fact : sample) text += fact.name + "=" + fact.text + "\n";
  return text;
}

}  // namespace patinate::capture
