//! What a frame and an instruction word cost.
use amacrine::{
    array::{Arithmetic, Array, Settings},
    event::Packet,
    isa::Device,
    plane::{Plane, Size},
    program::{Overrides, Program},
    unit::Micros,
};
use std::time::Instant;
fn main() {
    let device = Device::scamp5();
    let size = Size::new(256, 256);
    let text = std::fs::read_to_string("programs/rgc/centre_surround.scamp").unwrap();
    let program = Program::parse("x", &text).unwrap();
    let code = program.expand(&device, &Overrides::default()).unwrap().code;
    let light = Plane::from_shape_fn(size.shape(), |(y, x)| ((y * 7 + x * 13) % 256) as f64);
    for name in [
        "exact", "f32", "f16", "bf16", "q8.8", "q1.7", "q8.24", "silicon",
    ] {
        let a: Arithmetic = name.parse().unwrap();
        let mut chip: Box<dyn Array + Send> = a
            .chip("x", code.clone(), &device, size, Settings::of(&device))
            .unwrap();
        let mut packet = Packet::new(size, 1);
        chip.expose(&light).unwrap();
        chip.run_init(Micros(0), &mut packet).unwrap();
        let (mut be, mut br) = (f64::MAX, f64::MAX);
        for _ in 0..100 {
            packet.events.clear();
            let t = Instant::now();
            chip.expose(&light).unwrap();
            let e = t.elapsed().as_secs_f64();
            let t = Instant::now();
            chip.run_frame(Micros(0), &mut packet).unwrap();
            be = be.min(e);
            br = br.min(t.elapsed().as_secs_f64());
        }
        println!(
            "{name:8} expose {:8.1} us  frame {:8.1} us  {} events",
            be * 1e6,
            br * 1e6,
            packet.events.len()
        );
    }
}
