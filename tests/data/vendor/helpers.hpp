#ifndef HELPERS_HPP
#define HELPERS_HPP
#include <scamp5.hpp>
using namespace SCAMP5_PE;

// A rectangle around a centre.
void load_centred(dreg_t reg, int x, int y, int width, int height = 8)
{
    int top = y - height / 2;
    if (top < 0) {
        height += top;
        top = 0;
    }
    int right = x - width / 2;
    scamp5_load_rect(reg, top, right, top + height, right + width);
}
#endif
