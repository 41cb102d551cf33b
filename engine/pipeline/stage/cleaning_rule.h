// What cleaning follows from the scans, and how far the passes over raw points reach.
#pragma once

#include "engine/normals/estimate_normals.h"
#include "engine/pipeline/stage/partition.h"
#include "engine/pipeline/stage/resolved_job.h"
#include "engine/spacing/noise_places.h"
#include "io/report/report.h"

namespace orbweave {

/// What was measured of the scans, and what cleaning is applied. `reason` says both in words, and
/// where nothing is applied what automatic cleaning would do.
CleaningFacts cleaning_for(const CleaningOptions& wanted, const Partition& scans);

/// How noise is measured place by place; without a token to stop by.
NoisePlaceOptions noise_options(const Partition& scans);

/// Distance between neighbours once points closer than a tolerance are one. Points taken in no
/// order until no more fit at that distance from each other cover 0.547 of a plane with discs of
/// half of it (Renyi 1958; Feder 1980); as many points on a square grid lie 1.2 tolerances apart.
double merged_spacing(const CleaningOptions& cleaning);

/// Radius within which the neighbours of a point are found for its normal: as measured on the
/// scans, and beyond where merged points lie farther apart. The farthest of k neighbours in a plane
/// is sqrt(k / pi) spacings away; half as far again where points are sparse.
double reach_of_normals(const ResolvedJob& job, const Partition& scans,
                        const CleaningOptions& cleaning);

/// How normals of the scans are estimated; without a token to stop by.
NormalEstimateOptions estimate_options(const ResolvedJob& job, const Partition& scans,
                                       const CleaningOptions& cleaning);

/// How far beyond a chunk the passes look: for the farthest neighbour that makes an outlier or a
/// normal. 0: no pass is on, or `scans` were not measured.
double reach_of_cleaning(const ResolvedJob& job, const Partition& scans);

}  // namespace orbweave
