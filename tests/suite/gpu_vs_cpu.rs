//! gpu_vs_cpu
