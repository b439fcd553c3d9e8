//! Refuses a processor for which the program was not built.

/// What the program may use and the processor lacks.
///
/// `is_x86_feature_detected` does not tell: of what the program is built for it says yes without asking.
#[cfg(target_arch = "x86_64")]
pub fn missing() -> Vec<&'static str> {
    let cpu = raw_cpuid::CpuId::new();
    let (basic, extended) = (cpu.get_feature_info(), cpu.get_extended_feature_info());
    let basic = |has: fn(&raw_cpuid::FeatureInfo) -> bool| basic.as_ref().is_some_and(has);
    let extended = |has: fn(&raw_cpuid::ExtendedFeatures) -> bool| extended.as_ref().is_some_and(has);
    let used = [
        ("avx512f", cfg!(target_feature = "avx512f"), extended(|has| has.has_avx512f())),
        ("avx512dq", cfg!(target_feature = "avx512dq"), extended(|has| has.has_avx512dq())),
        ("avx512vl", cfg!(target_feature = "avx512vl"), extended(|has| has.has_avx512vl())),
        ("avx2", cfg!(target_feature = "avx2"), extended(|has| has.has_avx2())),
        ("bmi2", cfg!(target_feature = "bmi2"), extended(|has| has.has_bmi2())),
        ("avx", cfg!(target_feature = "avx"), basic(|has| has.has_avx())),
        ("fma", cfg!(target_feature = "fma"), basic(|has| has.has_fma())),
    ];
    used.into_iter().filter(|&(_, built_for, has)| built_for && !has).map(|(name, ..)| name).collect()
}

/// Of other architectures nothing is known.
#[cfg(not(target_arch = "x86_64"))]
pub fn missing() -> Vec<&'static str> {
    Vec::new()
}
