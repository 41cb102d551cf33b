#include "io/points/own_attribute.h"

#include "io/text/distinct_names.h"

namespace orbweave {

void add_own_attribute(PointSchema& schema, const AttributeField& own) {
  DistinctNames names({own.name});
  for (const AttributeField& field : schema.attributes) names.take(field.name);
  for (AttributeField& field : schema.attributes)
    if (field.name == own.name) field.name = names.give("scan_" + own.name);
  schema.attributes.push_back(own);
}

}  // namespace orbweave
