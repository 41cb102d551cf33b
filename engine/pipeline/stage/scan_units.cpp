#include "engine/pipeline/stage/scan_units.h"

namespace orbweave {

double meters_per_unit(const ResolvedJob& job, const Partition& partition) {
  if (job.input.units_per_meter) return 1.0 / *job.input.units_per_meter;
  return partition.meters_per_unit ? partition.meters_per_unit->x : 0.0;
}

}  // namespace orbweave
