//! Raw bindings to Intel Embree 4.
