#include "libcommon/job/job_record.h"
#include "tests/fuzz/fuzz_target.h"

using namespace patinate;

PATINATE_FUZZ_TARGET(job_record) {
  const auto file = fuzz::fuzz_file(kJobRecordFile, bytes);
  const JobRecord record = read_job_record(file.parent_path(), "k");
  fuzz::require(record.key.empty() || record.key == "k", "a record of another manifest is none");
  (void)changes_between(record.depends_on, {{"--sigma", "2"}, {"photo", "x"}});
  if (!record.key.empty()) write_job_record(file.parent_path(), record);
}
