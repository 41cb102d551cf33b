#include "engine/pipeline/stage/scan_units.h"

#include "io/points/length_units.h"

namespace orbweave {

double meters_per_unit(const ResolvedJob& job, const Partition& partition) {
  return meters_per_unit(job.input.units_per_meter, partition.meters_per_unit).value_or(Vec3{}).x;
}

}  // namespace orbweave
