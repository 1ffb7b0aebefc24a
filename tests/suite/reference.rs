//! The reference renderer against brute force, quadrature and closed forms; its backends.

mod backends;
