// A kernel as compilers of filters write it.
#define west(X,Y)   {mov(X,Y,west);}
#define add_sure(X, Y, Z)({\
    mov(F, Z);\
    add(X, Y, F);\
})
scamp5_kernel_begin();
    get_image(A, F);
    // [A] -> [A]
    south(A, A);
    div2_inplace(A, A);
    west(B, A);
    neg_inplace(B, B);
    div2(C, B);
    north(D, C);
    sub(B, B, D);
    add_twice(C, C, C);
    sub_inplace(A, B, A);
    add_sure(A, A, C);
    bus2_3(D, E, A);
scamp5_kernel_end();
