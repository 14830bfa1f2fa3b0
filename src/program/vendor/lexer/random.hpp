// The generator of random numbers that the vendor's box has: Marsaglia's two sequences, each a
// multiplication with carry, of 16 bits a step.
struct vs_random {
    uint32_t seed = 0;
    uint32_t high = 362436069u;
    uint32_t low = 521288629u;
    vs_random(uint32_t from = 0) { reseed(from); }
    void reseed(uint32_t from) { seed = from; reset(); }
    void reset() { high = 362436069u - seed; low = 521288629u + seed; }
    uint32_t get_seed() { return seed; }
    void step() {
        high = 36969u * (high % 65536u) + high / 65536u;
        low = 18000u * (low % 65536u) + low / 65536u;
    }
    uint32_t get_uint32() { step(); return high * 65536u + low % 65536u; }
    uint16_t get_uint16() { step(); return high * 256u + low % 256u; }
    int get_int(int least, int most) {
        uint32_t choices = most - least + 1;
        uint32_t drawn = get_uint16();
        return (int)(drawn * choices / 65536u) + least;
    }
    bool chance(uint16_t of, uint16_t all) { uint32_t drawn = get_uint16(); return all * drawn < of * 65536u; }
    int operator()(int least, int most) { return get_int(least, most); }
};
