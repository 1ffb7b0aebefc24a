//! All file reading and writing.
