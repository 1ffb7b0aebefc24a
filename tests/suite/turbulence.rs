//! turbulence
