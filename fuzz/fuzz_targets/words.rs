#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    amacrine_fuzz::words(bytes);
});
