//! Refuses a processor for which the program was not built.

/// Returns a feature that the program may use and the processor lacks.
///
/// `is_x86_feature_detected` does not work here: for features that the program is built for it
/// returns true without asking. The bits are copied one by one because copying a structure could
/// use the very registers that the processor lacks.
#[cfg(target_arch = "x86_64")]
pub fn missing_feature() -> Option<&'static str> {
    use raw_cpuid::native_cpuid::cpuid_count;
    let (basic, extended) = (cpuid_count(1, 0).ecx, cpuid_count(7, 0).ebx);
    if cfg!(target_feature = "avx") && basic >> 28 & 1 == 0 {
        Some("avx")
    } else if cfg!(target_feature = "fma") && basic >> 12 & 1 == 0 {
        Some("fma")
    } else if cfg!(target_feature = "avx2") && extended >> 5 & 1 == 0 {
        Some("avx2")
    } else if cfg!(target_feature = "bmi2") && extended >> 8 & 1 == 0 {
        Some("bmi2")
    } else if cfg!(target_feature = "avx512f") && extended >> 16 & 1 == 0 {
        Some("avx512f")
    } else if cfg!(target_feature = "avx512vl") && extended >> 31 & 1 == 0 {
        Some("avx512vl")
    } else {
        None
    }
}

/// Returns `None`: other architectures are not checked.
#[cfg(not(target_arch = "x86_64"))]
pub fn missing_feature() -> Option<&'static str> {
    None
}
