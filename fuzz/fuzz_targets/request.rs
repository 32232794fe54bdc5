#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| (pschema_tests::fuzz::target("request").read)(bytes));
