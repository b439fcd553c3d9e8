//! Refuses a processor for which the program was not built.

/// Something that the program may use and the processor lacks.
///
/// `is_x86_feature_detected` does not tell: of what the program is built for it says yes without asking. There are no
/// lists here because copying one could take the very registers that the processor lacks.
#[cfg(target_arch = "x86_64")]
pub fn missing() -> Option<&'static str> {
    let cpu = raw_cpuid::CpuId::new();
    let basic = cpu.get_feature_info()?;
    let lacks = |built_for: bool, has: bool| built_for && !has;
    if lacks(cfg!(target_feature = "avx"), basic.has_avx()) {
        return Some("avx");
    }
    if lacks(cfg!(target_feature = "fma"), basic.has_fma()) {
        return Some("fma");
    }
    let extended = cpu.get_extended_feature_info();
    if lacks(cfg!(target_feature = "avx2"), extended.as_ref().is_some_and(|has| has.has_avx2())) {
        return Some("avx2");
    }
    if lacks(cfg!(target_feature = "bmi2"), extended.as_ref().is_some_and(|has| has.has_bmi2())) {
        return Some("bmi2");
    }
    if lacks(cfg!(target_feature = "avx512f"), extended.as_ref().is_some_and(|has| has.has_avx512f())) {
        return Some("avx512f");
    }
    let vector_lengths = extended.as_ref().is_some_and(|has| has.has_avx512vl());
    lacks(cfg!(target_feature = "avx512vl"), vector_lengths).then_some("avx512vl")
}

/// Of other architectures nothing is known.
#[cfg(not(target_arch = "x86_64"))]
pub fn missing() -> Option<&'static str> {
    None
}
