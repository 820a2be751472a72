//! Etendue: a Monte Carlo renderer on Intel Embree 4.
