//! Headless device, small scenes and comparators for the suite.
