// Objects of the module as values that pickle and copy take.
#pragma once

#include <pybind11/pybind11.h>

#include "python/src/objects.h"

namespace orbweave::python {

/// What an object is made of: numbers, lists, and arrays as the bytes that they lie in.
pybind11::tuple state_of(const HoleFacts& hole);
pybind11::tuple state_of(const CloudObject& object);
pybind11::tuple state_of(const MeshObject& object);

/// The object of such a state. Throws Error (usage) where it is none.
HoleFacts hole_of_state(const pybind11::tuple& state);
CloudObject cloud_of_state(const pybind11::tuple& state);
MeshObject mesh_of_state(const pybind11::tuple& state);

}  // namespace orbweave::python
