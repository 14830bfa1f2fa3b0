//! Vendor C++: classes, operators, containers, templates and types. What a program computes here a
//! compiler makes of it too: the numbers are those of g++.

use amacrine::{
    isa::Device,
    program::{Overrides, Program},
};

mod vendor_cpp;
use vendor_cpp::{expand, loaded, numbers, told};

/// Functions of a base, those in their place, and parts of objects.
#[test]
fn classes_are_made_from_others() {
    numbers(
        r"struct Shape { int w; int h; Shape(int a, int b = 2) : w(a), h(b) {} virtual int area() const { return w * h; } int twice() const { return 2 * area(); } int wide() const { return w; } virtual ~Shape() {} };
struct Box : public Shape { int d; Box(int a) : Shape(a, 3), d(4) {} int area() const override { return Shape::area() + d; } };
struct Cube final : Box { Cube() : Box(5) { d = 7; } int area() const final { return 1 + Box::area(); } int grow() { w++; return wide(); } };
struct Plain { int x = 3; int get() const { return x; } }; struct More : Plain { int y = 9; int both() { return x * 10 + y; } };
int show(const Shape& s) { return s.area(); } int part(Shape s) { return s.area(); } void widen(Shape& s) { s.w += 10; }",
        r"Shape s(3); Box b(2); Cube c; Shape* all[] = {&s, &b, &c};
for (Shape* p : all) { scamp5_in(A, p->area()); scamp5_in(A, p->twice()); }
for (auto* p : all) scamp5_in(B, show(*p));
scamp5_in(C, part(b)); widen(b); scamp5_in(C, b.area()); Shape copy = c; scamp5_in(C, copy.area()); scamp5_in(C, c.grow());
More m; scamp5_in(D, m.both()); scamp5_in(D, m.get()); m.x = 1; scamp5_in(D, m.both());
std::vector<Shape*> v; v.push_back(new Cube()); v.push_back(&b); for (auto it = v.begin(); it != v.end(); ++it) scamp5_in(A, (*it)->area());
Shape& r = c; scamp5_in(A, r.area()); c.w = 1; scamp5_in(A, r.twice());",
        &[
            6, 12, 10, 20, 23, 46, 6, 10, 23, 6, 40, 15, 6, 39, 3, 19, 23, 40, 26, 22,
        ],
    );
}

/// What a pointer leads to says which function runs.
#[test]
fn virtual_functions_are_those_of_the_object() {
    numbers(
        r#"class Step { public: virtual int run(int x) = 0; virtual const char* name() const { return "step"; } virtual ~Step() = default; int chain(int x) { return run(run(x)); } };
class Add : public Step { int n; public: explicit Add(int k) : n(k) {} int run(int x) override { return x + n; } };
class Mul : public Step { public: virtual int run(int x) override { return x * 3; } const char* name() const override { return "multiply"; } };
int over(int n, Step** all, int x) { for (int i = 0; i < n; i++) x = all[i]->run(x); return x; }"#,
        r"Add a(2); Mul m; Step* all[2] = {&a, &m}; scamp5_in(A, over(2, all, 5)); scamp5_in(A, a.chain(1)); scamp5_in(A, m.chain(1));
scamp5_in(B, (int)strlen(all[0]->name())); scamp5_in(B, (int)strlen(all[1]->name()));",
        &[21, 5, 9, 4, 8],
    );
}

/// Inside of a class and outside.
#[test]
fn operators_of_classes() {
    numbers(
        r"struct V { int x; int y; V operator+(const V& o) const { return V{x + o.x, y + o.y}; } V operator-() const { return {-x, -y}; } V& operator+=(const V& o) { x += o.x; y += o.y; return *this; } bool operator==(const V& o) const { return x == o.x && y == o.y; } int operator[](int i) const { return i ? y : x; } };
V operator*(int k, const V& v) { return V{k * v.x, k * v.y}; } V operator*(const V& v, int k) { return k * v; } bool operator!=(const V& a, const V& b) { return !(a == b); } bool operator<(const V& a, const V& b) { return a.x < b.x; }
struct Table { int data[4] = {1, 2, 3, 4}; int& operator[](int i) { return data[i & 3]; } int operator()(int a, int b) const { return data[a] * 10 + b; } Table& operator++() { data[0]++; return *this; } };
struct Scale { float k; Scale(float f) : k(f) {} int operator()(int x) const { return (int)(k * x); } };",
        r"V a{1, 2}, b{3, 4}; V c = a + b; scamp5_in(A, c.x); scamp5_in(A, c.y); c += a; scamp5_in(A, c[0]); scamp5_in(A, c[1]);
scamp5_in(B, a == b); scamp5_in(B, a != b); scamp5_in(B, a < b); V d = 3 * a + b * 2; scamp5_in(B, d.x); scamp5_in(B, (-d).y); scamp5_in(B, (a + b + c)[1]); V e = d; e = a; scamp5_in(B, e == a);
Table t; t[1] = 9; t[6] += 5; scamp5_in(C, t[1]); scamp5_in(C, t[2]); scamp5_in(C, t(1, 5)); ++t; scamp5_in(C, t[0]); Scale half(0.5f); scamp5_in(C, half(9)); scamp5_in(C, Scale(2.5f)(3));",
        &[4, 6, 5, 8, 0, 1, 1, 9, -14, 14, 1, 9, 8, 95, 2, 4, 7],
    );
}

/// They have the types that they are given.
#[test]
fn pairs_and_tuples() {
    numbers(
        r"std::tuple<int, float, int> triple(int x) { return std::make_tuple(x, x * 2, x * 3); } std::pair<int, int> both(int x) { return {x, -x}; }
using Shift = std::pair<int, int>; static std::vector<Shift> path(int n) { std::vector<Shift> p; for (int i = 0; i < n; ++i) p.push_back({i % 3 - 1, (i & 1) ? -1 : 1}); p.emplace_back(7, 8); return p; }",
        r"int a, b, c; std::tie(a, b, c) = triple(4); scamp5_in(A, a); scamp5_in(A, b); scamp5_in(A, c); scamp5_in(A, std::get<2>(triple(5)));
std::tie(a, std::ignore) = both(6); scamp5_in(A, a); std::tie(a, b) = std::make_pair(b, a); scamp5_in(A, a); scamp5_in(A, b);
for (const auto& s : path(2)) { scamp5_in(B, s.first); scamp5_in(B, s.second); } for (auto [x, y] : path(1)) scamp5_in(B, x * 10 + y);
std::pair<int, float> p(3, 1); scamp5_in(C, (int)(p.second / 2 * 10)); auto q = std::make_pair('a', 2.5); scamp5_in(C, sizeof(q.first)); scamp5_in(C, (int)(q.second * 2)); std::get<0>(p) = 9; scamp5_in(C, p.first);
std::pair<uint8_t, int> w{250, 1}; w.first += 10; scamp5_in(C, w.first); scamp5_in(C, both(1) == both(1)); scamp5_in(C, both(1) < both(2)); auto [m, n] = both(3); scamp5_in(C, n);
std::vector<std::pair<int, int>> v = {{3, 1}, {1, 2}, {1, 1}}; std::sort(v.begin(), v.end()); for (auto& e : v) scamp5_in(D, e.first * 10 + e.second);",
        &[
            4, 8, 12, 15, 6, 8, 6, -1, 1, 0, -1, 7, 8, -9, 78, 5, 1, 5, 9, 4, 1, 1, -3, 11, 12, 31,
        ],
    );
}

/// What leads to an element leads there whatever is added before it.
#[test]
fn maps_have_their_elements_by_key() {
    numbers(
        r#"enum Mode { IDLE, RUN = 4, STOP }; struct P { int x; int y = 5; };
std::map<std::string, int> params = {{"threshold", 14}, {"iterations", 3}};
int get(const std::map<std::string, int>& m, const std::string& key, int other) { auto it = m.find(key); return it == m.end() ? other : it->second; }"#,
        r#"scamp5_in(A, params["threshold"]); params["iterations"]++; scamp5_in(A, params.at("iterations")); scamp5_in(A, (int)params.size()); scamp5_in(A, params["none"]); scamp5_in(A, (int)params.size());
scamp5_in(A, get(params, "threshold", 1)); scamp5_in(A, get(params, "gain", 1));
std::map<int, float> m; m[5] = 1; m[-2] = 2.5f; m[3] += 4; for (auto& kv : m) { scamp5_in(B, kv.first); scamp5_in(B, (int)(kv.second * 2)); kv.second = 1; } for (const auto& [k, v] : m) scamp5_in(B, k * 10 + (int)v);
auto& five = m[5]; m[0] = 9; five = 77; scamp5_in(C, (int)m[5]); scamp5_in(C, (int)m[0]); scamp5_in(C, (int)m.erase(3)); scamp5_in(C, (int)m.count(3)); scamp5_in(C, (int)m.count(5)); scamp5_in(C, m.find(3) == m.end());
for (auto it = m.begin(); it != m.end(); ) { if (it->first < 0) it = m.erase(it); else ++it; } scamp5_in(C, (int)m.size()); scamp5_in(C, m.begin()->first);
std::map<Mode, const char*> names = {{RUN, "run"}, {IDLE, "idle"}}; scamp5_in(D, (int)strlen(names[IDLE])); std::map<char, std::vector<int>> lists; lists['a'].push_back(3); lists['a'].push_back(4); scamp5_in(D, lists['a'][1]); scamp5_in(D, (int)lists['b'].size());
std::unordered_map<int, P> objects; objects[2].x = 6; objects.insert({3, P{1, 2}}); auto r = objects.insert({3, P{9, 9}}); scamp5_in(D, r.second); scamp5_in(D, objects[3].x); scamp5_in(D, objects[2].y); objects.emplace(4, P{8, 8}); scamp5_in(D, objects.at(4).y); scamp5_in(D, (int)objects.size());
std::map<std::string, std::map<int, int>> nested; nested["a"][2] = 3; nested["a"][2]++; scamp5_in(D, nested["a"][2]); auto copy = params; copy["threshold"] = 1; scamp5_in(D, params["threshold"]);"#,
        &[
            14, 4, 2, 0, 3, 14, 1, -2, 5, 3, 8, 5, 2, -19, 31, 51, 77, 9, 1, 0, 1, 1, 2, 0, 4, 4,
            0, 0, 1, 5, 8, 3, 4, 14,
        ],
    );
}

/// Braces with names, objects that an array makes, the largest of a list.
#[test]
fn members_by_name_and_objects_in_place() {
    numbers(
        r"struct Cfg { int th = 10; int n; float gain = 1.5f; int all[2]; }; struct Outer { Cfg c; int k; }; struct P { int v; P(int x) : v(x) {} P(int a, int b) : v(a * b) {} P() : v(7) {} }; struct Q { int a; uint8_t b; };
int total(const Cfg& c) { return c.th + c.n; } int sum(const std::vector<Q>& all) { int s = 0; for (auto& q : all) s += q.a * q.b; return s; }",
        r"Cfg c = {.n = 4, .all = {5, 6}}; scamp5_in(A, c.th); scamp5_in(A, c.n); scamp5_in(A, (int)(c.gain * 2)); scamp5_in(A, c.all[1]); Cfg d{.th = 1}; scamp5_in(A, d.th); scamp5_in(A, d.n);
scamp5_in(B, total({.th = 2, .n = 3})); Outer o = {.c = {.n = 8}, .k = 9}; scamp5_in(B, o.c.th + o.c.n + o.k); c = {.n = 1}; scamp5_in(B, c.th * 10 + c.n); static const Cfg table[] = {{.n = 1}, {.th = 3, .n = 2}}; scamp5_in(B, table[1].th); scamp5_in(B, total(Cfg{.n = 20}));
std::vector<P> v; v.push_back(P(4)); v.emplace_back(6); v.emplace_back(2, 9); v.emplace_back(); for (auto& p : v) scamp5_in(C, p.v); std::vector<Q> w; w.emplace_back(Q{1, 2}); w.push_back({3, (uint8_t)258}); scamp5_in(C, w[1].b); scamp5_in(C, sum(w)); w.resize(3); scamp5_in(C, w[2].a);
scamp5_in(D, std::max({1, 9, 3})); scamp5_in(D, std::min({4, 2, 8})); int k = 3; scamp5_in(D, std::max({k, k * 2, 5}));",
        &[
            10, 4, 3, 6, 1, 0, 5, 27, 101, 3, 30, 4, 6, 18, 7, 2, 8, 0, 9, 2, 6,
        ],
    );
}

/// The body is that for what is given or deduced.
#[test]
fn templates_have_bodies_of_their_own_for_some() {
    numbers(
        r"template <int N> int fact() { return N * fact<N - 1>(); } template <> int fact<0>() { return 1; }
template <typename T> int bytes(T x) { return sizeof(T); } template <> int bytes<float>(float x) { return 40; } template <> int bytes(bool x) { return 70; }
enum Op { ERODE, DILATE }; template <Op O> int morph(int x); template <> int morph<ERODE>(int x) { return x - 1; } template <> int morph<DILATE>(int x) { return x + 1; }",
        r"scamp5_in(A, fact<5>()); scamp5_in(A, bytes(1)); scamp5_in(A, bytes(1.0f)); scamp5_in(A, bytes(1.0)); scamp5_in(A, bytes(true)); scamp5_in(A, bytes<float>(3));
scamp5_in(B, morph<DILATE>(5)); scamp5_in(B, morph<ERODE>(5));",
        &[120, 4, 40, 8, 70, 40, 6, 4],
    );
}

/// The numbers are those of g++.
#[test]
fn the_mathematical_library_is_that_of_cpp() {
    numbers(
        "",
        r"double q = 0.0 / 0.0; double z = 1.5; scamp5_in(A, std::isnan(q)); scamp5_in(A, isnan(z)); scamp5_in(A, std::isinf(1 / 0.0)); scamp5_in(A, std::isfinite(z)); scamp5_in(A, std::signbit(-0.0));
scamp5_in(B, lrint(2.5)); scamp5_in(B, lrintf(-3.5f)); scamp5_in(B, labs(-7L)); scamp5_in(B, sizeof(labs(-7L))); scamp5_in(B, (int)copysign(3.0, -1.0)); scamp5_in(B, (int)fdim(9.0, 4.5) * 2); scamp5_in(B, (int)fma(2.0, 3.0, 4.0)); scamp5_in(B, (int)(remainder(7.0, 4.0) * 2));
scamp5_in(C, (int)ldexp(3.0, 4)); scamp5_in(C, (int)(std::log1p(1.0) * 100)); scamp5_in(C, (int)(expm1(1.0) * 10)); scamp5_in(C, (int)(asinh(2.0) * 10)); scamp5_in(C, (int)(erf(0.5) * 100)); scamp5_in(C, sizeof(copysignf(1.0f, 2.0f)));",
        &[
            1, 0, 1, 1, 1, 2, -4, 7, 8, -3, 8, 10, -2, 48, 69, 17, 14, 52, 4,
        ],
    );
}

/// Characters, what functions give back, choices, a variable inside its own value.
#[test]
fn expressions_have_the_types_of_cpp() {
    numbers(
        r"int f(int) { return 1; } int f(char) { return 3; } int f(double) { return 2; } int f(bool) { return 6; } int f(uint8_t) { return 7; } int f(unsigned) { return 5; } char letter() { return 'q'; } uint8_t byte() { return 9; }
int table[4] = {1, 2, 3, 4}; auto at(int i) -> int& { return table[i]; } auto half(int x) -> float { return x / 2.0; } struct S { int v = 4; auto ref() -> int& { return v; } };",
        r"scamp5_in(A, f('a')); scamp5_in(A, f('a' + 1)); scamp5_in(A, sizeof('a')); char c = 'a'; scamp5_in(A, f(c)); auto x = 'a'; scamp5_in(A, f(x)); scamp5_in(A, sizeof(x)); scamp5_in(A, f(letter())); scamp5_in(A, sizeof(letter())); scamp5_in(A, f(byte())); auto b = byte(); b += 250; scamp5_in(A, b); scamp5_in(A, f(true ? 1 : 2.5)); int k = 1; scamp5_in(A, (int)((k ? 1 : 2.5) / 2 * 10)); scamp5_in(A, f(k ? 'a' : 'b')); scamp5_in(A, f(1u + 1)); scamp5_in(A, f(!k));
at(2) = 50; at(0)++; scamp5_in(B, table[2]); scamp5_in(B, table[0]); scamp5_in(B, (int)(half(5) * 2)); S s; s.ref() = 8; scamp5_in(B, s.v);
int vals[] = {1, 2, (int)sizeof(vals[0])}; scamp5_in(C, vals[2]); const uint16_t small[2] = {sizeof(small[0]), sizeof(small)}; scamp5_in(C, small[0]); scamp5_in(C, small[1]);
std::function<int(int)> fib = [&](int n) { return n < 2 ? n : fib(n - 1) + fib(n - 2); }; scamp5_in(C, fib(8));
uint8_t bytes[3] = {250, 1, 2}; for (auto y : bytes) { y += 10; scamp5_in(D, y); }",
        &[
            3, 1, 1, 3, 3, 1, 3, 1, 7, 3, 2, 5, 3, 5, 6, 50, 2, 5, 8, 4, 2, 4, 21, 4, 11, 12,
        ],
    );
}

/// In namespaces, announced in the class; overloads and lambdas inside of it.
#[test]
fn functions_stand_behind_their_class() {
    numbers(
        r"namespace geo { class Track { int n = 0; std::vector<std::pair<int, int>> all; public: explicit Track(int k) : n(k) {} void add(int x, int y = 1); int size() const; virtual int weight() const; static int count(); int over(int) { return 1; } int over(double) { return 2; } int which() { return over(1) * 10 + over(2.5); } };
struct V { int x; V operator+(V o) const { return V{x + o.x}; } }; V operator-(V a, V b) { return {a.x - b.x}; } }
void geo::Track::add(int x, int y) { all.emplace_back(x, y); n += y; }
int geo::Track::size() const { return (int)all.size() + n; }
int geo::Track::weight() const { return 3; }
int geo::Track::count() { return 8; }
struct Heavy : public geo::Track { Heavy() : geo::Track(50) {} int weight() const override { return 2 * geo::Track::weight(); } };
struct S { int n = 1; int f() { auto g = [=]() { return n; }; n = 5; return g(); } int h() { auto g = [this](int k) { n += k; return twice(); }; return g(2); } int twice() { return 2 * n; } };
struct Q { int a; int b; }; int sum(std::vector<Q> all) { int s = 0; for (auto& q : all) s += q.a * q.b; return s; } int twice(int x) { return -x; }",
        r"geo::Track t(2); t.add(4); t.add(5, 3); scamp5_in(A, t.size()); scamp5_in(A, t.weight()); scamp5_in(A, geo::Track::count()); scamp5_in(A, t.which());
Heavy h; geo::Track* p = &h; scamp5_in(A, p->weight()); p->add(1, 1); scamp5_in(A, h.size()); scamp5_in(A, p->size());
geo::V a{4}, b{1}; scamp5_in(B, (a + b).x); scamp5_in(B, (a - b).x);
S s; scamp5_in(C, s.f()); scamp5_in(C, s.h()); scamp5_in(C, twice(3)); std::vector<Q> w; w.push_back({1, 2}); Q x{3, 4}; w.push_back(x); scamp5_in(D, sum(w));",
        &[8, 3, 8, 12, 6, 52, 52, 5, 3, 5, 14, -3, 14],
    );
}

/// Constructors of bases and of the same class, texts and arrays in objects, operators that change them.
#[test]
fn objects_are_made_and_copied() {
    numbers(
        r"struct Base { int id; Base() : id(1) { start(); } virtual void start() { id += 10; } int get() { return id; } }; struct Derived : Base { int extra = 2; void start() override { id += 100; } Derived() { extra += id; start(); } Derived(int k) : Derived() { extra += k; } };
struct Item { std::string name; int n; Item(const std::string& s, int k) : name(s), n(k) {} bool operator<(const Item& o) const { return n < o.n; } };
struct Mat { float m[2][2]; float& operator()(int i, int j) { return m[i][j]; } Mat operator*(const Mat& o) const { Mat r; for (int i = 0; i < 2; i++) for (int j = 0; j < 2; j++) { r.m[i][j] = 0; for (int k = 0; k < 2; k++) r.m[i][j] += m[i][k] * o.m[k][j]; } return r; } };
struct Counter { int n = 0; Counter& operator++() { ++n; return *this; } Counter operator++(int) { Counter old = *this; n++; return old; } Counter& operator<<(int k) { n += k; return *this; } bool operator!() const { return n == 0; } Counter& operator=(int k) { n = k; return *this; } };
int kinds(const Base&) { return 1; } int kinds(int) { return 2; }",
        r#"Derived d; scamp5_in(A, d.id); scamp5_in(A, d.extra); Derived e(5); scamp5_in(A, e.extra); Base& r = d; scamp5_in(A, r.get()); scamp5_in(A, kinds(d)); Base copy(d); scamp5_in(A, copy.id);
std::vector<Item> items; items.emplace_back("a", 3); items.emplace_back(std::string("bc"), 1); items.push_back(Item("d", 2)); int len = 0; for (const auto& it : items) len += (int)it.name.size() * it.n; scamp5_in(B, len);
Mat m; m(0, 0) = 1; m(0, 1) = 2; m(1, 0) = 3; m(1, 1) = 4; Mat q = m * m; scamp5_in(B, (int)q(1, 0)); scamp5_in(B, (int)(m * q)(0, 1));
Counter c; scamp5_in(C, !c); ++c; Counter old = c++; scamp5_in(C, old.n); scamp5_in(C, c.n); c << 3 << 4; scamp5_in(C, c.n); c = 6; scamp5_in(C, c.n); scamp5_in(C, !c);"#,
        &[111, 13, 18, 111, 1, 111, 7, 15, 54, 1, 1, 2, 9, 6, 0],
    );
}

/// In objects and maps, of functions, under `auto`.
#[test]
fn arrays_of_the_library_are_copied() {
    numbers(
        r"struct S { std::vector<int> all; int raw[2]; }; std::vector<int> some() { std::vector<int> v = {1, 2}; return v; } struct Bl { int get() const; int x = 2; }; int Bl::get() const { return x; }
int first(std::vector<int> v) { v[0] += 5; return v[0]; }",
        r"S s; s.all.push_back(1); s.raw[0] = 3; auto copy = s.all; copy[0] = 9; scamp5_in(A, s.all[0]); auto p = s.raw; p[0] = 4; scamp5_in(A, s.raw[0]); auto& same = s.all; same[0] = 7; scamp5_in(A, s.all[0]);
auto v = some(); auto w = v; w[0] = 50; scamp5_in(B, v[0]); std::vector<std::vector<int>> grid = {{1, 2}, {3, 4}}; auto row = grid[1]; row[0] = 8; scamp5_in(B, grid[1][0]); auto& r = grid[1]; r[0] = 6; scamp5_in(B, grid[1][0]); scamp5_in(B, (int)v.size()); scamp5_in(B, first(v)); scamp5_in(B, v[0]);
std::map<int, std::vector<int>> m; m[1].push_back(4); auto old = m[1]; old[0] = 5; scamp5_in(C, m[1][0]); for (auto x : grid) x[0] = 0; scamp5_in(C, grid[0][0]); Bl b; scamp5_in(D, b.get()); Bl bs[2]; scamp5_in(D, (bs + 1)->get()); scamp5_in(D, first(s.all)); scamp5_in(D, s.all[0]);",
        &[1, 4, 7, 1, 3, 6, 2, 6, 1, 4, 1, 2, 2, 12, 7],
    );
}

/// With and without a body in the class.
#[test]
fn friends_are_functions_of_the_namespace() {
    numbers(
        r"class Vec { float x, y; public: friend class Other; Vec(float a = 0, float b = 0) : x(a), y(b) {} friend Vec operator*(float k, const Vec& v) { return Vec(v.x * k, v.y * k); } friend bool operator==(const Vec& a, const Vec& b) { return a.x == b.x && a.y == b.y; } friend int peek(const Vec& v); int half() const { return (int)(y / 2); } };
int peek(const Vec& v) { return (int)v.x; } struct P { friend struct Q; int a; int b; };
std::map<int, int> build(int n) { std::map<int, int> s; for (int i = n; i > 0; --i) s[i % 3] = i; return s; }",
        r"Vec a(1, 4); scamp5_in(A, peek(3.0f * a)); scamp5_in(A, (2.0f * a).half()); scamp5_in(A, a == Vec(1, 4)); P p = {5, 6}; scamp5_in(A, p.b); for (const auto& e : build(5)) scamp5_in(B, e.first * 10 + e.second);",
        &[3, 4, 1, 6, 3, 11, 22],
    );
}

/// Arrays, vectors and pointers of them; lambdas, references into maps, tuples.
#[test]
fn objects_hold_objects() {
    numbers(
        r"struct A0 { int n = 1; int get() const { return n; } void set(int k) { n = k; } }; struct Holder { A0 a; A0 arr[2]; std::vector<A0> v; A0* p = nullptr; int sum() { int s = a.get(); for (auto& x : arr) s += x.get(); for (const auto& x : v) s += x.get(); if (p) s += p->get(); return s; } };
int apply(std::function<int(int)> f, int x) { return f(x); } struct Cnt { static int made; int id; Cnt() : id(++made) {} }; int Cnt::made = 0;
std::map<int, A0> store; A0& fetch(int k) { return store[k]; } const A0& peek(int k) { return store.at(k); }
std::vector<int> filter(const std::vector<int>& in, int t) { std::vector<int> out; for (int x : in) if (x > t) out.push_back(x); return out; }",
        r"Holder h; h.a.set(5); h.arr[1].set(7); h.v.push_back(A0{3}); h.v.emplace_back(); h.p = &h.arr[0]; h.p->set(20); scamp5_in(A, h.sum()); Holder g = h; g.a.set(0); g.v[0].set(9); scamp5_in(A, h.sum()); scamp5_in(A, g.sum());
int base = 4; scamp5_in(B, apply([base](int x) { return x + base; }, 3)); scamp5_in(B, apply([&](int x) { base += x; return base; }, 3)); scamp5_in(B, base); Cnt c1, c2; Cnt cs[2]; scamp5_in(B, cs[1].id); scamp5_in(B, Cnt::made);
fetch(2).set(6); scamp5_in(C, peek(2).get()); A0& r = fetch(2); fetch(1).set(3); r.set(8); scamp5_in(C, store[2].get()); scamp5_in(C, (int)store.size()); scamp5_in(C, filter({1, 5, 9}, 4)[1]); for (auto [i, a] : store) { a.set(0); scamp5_in(C, i); } scamp5_in(C, store[1].get());
std::pair<int, int> mm[2] = {{1, 2}, {3, 4}}; for (auto& [lo, hi] : mm) std::swap(lo, hi); scamp5_in(D, mm[1].first); auto t = std::make_tuple(1, 2.5f, 'c'); auto& [q, w, e] = t; w += 1; scamp5_in(D, (int)(std::get<1>(t) * 2)); scamp5_in(D, sizeof(e)); const int N = 3; int tot = 0; for (int i = N; i --> 0;) tot += i; scamp5_in(D, tot); int arr2[2][3] = {{1}, {4, 5}}; for (auto& row : arr2) for (int& x : row) x++; scamp5_in(D, arr2[1][2]); scamp5_in(D, arr2[0][0]);",
        &[
            56, 56, 57, 7, 7, 7, 4, 4, 6, 8, 2, 9, 1, 2, 3, 4, 7, 1, 3, 1, 2,
        ],
    );
}

/// Chains of filters, pointers that are chosen, parts of an object.
#[test]
fn objects_are_called_through_their_base() {
    numbers(
        r"struct Image { int w, h; explicit Image(int a, int b) : w(a), h(b) { size = w * h; } int size; }; class Filter { protected: int gain = 2; public: virtual int apply(int x) { return x * gain; } void setGain(int g) { gain = g; } }; class Offset : public Filter { int off; public: Offset(int o) : off(o) {} int apply(int x) override { return Filter::apply(x) + off; } }; class Chain : public Filter { std::vector<Filter*> all; public: Chain& add(Filter* f) { all.push_back(f); return *this; } int apply(int x) override { for (auto* f : all) x = f->apply(x); return x; } };
int run(Filter& f, int x) { return f.apply(x); } Filter* pick(bool b, Filter* p, Filter* q) { return b ? p : q; } struct Tag {}; struct Empty : Tag { int z = 3; };",
        r"Image im(3, 4); scamp5_in(A, im.size); Filter f; Offset o(5); Chain c; c.add(&f).add(&o); scamp5_in(A, run(c, 2)); f.setGain(3); scamp5_in(A, run(c, 2)); o.setGain(1); scamp5_in(A, c.apply(1)); scamp5_in(A, pick(true, &f, &o)->apply(1)); scamp5_in(A, pick(false, &f, &o)->apply(1)); Filter& fr = *pick(false, &f, &o); fr.setGain(4); scamp5_in(A, o.apply(1)); Filter* fs[] = {&c, &o, &f}; int s = 0; for (int i = 0; i < 3; i++) s += fs[i]->apply(1); scamp5_in(A, s); Empty e; scamp5_in(A, e.z); Offset* op = &o; Filter* fp = op; scamp5_in(A, fp == &o); scamp5_in(A, fp->apply(0)); Filter copy = *fp; scamp5_in(A, copy.apply(1));",
        &[12, 13, 17, 8, 3, 6, 9, 29, 3, 1, 5, 4],
    );
}

/// Pointers to objects, from behind, texts, what a function gives back.
#[test]
fn loops_over_what_is_no_array() {
    numbers(
        r"struct blob { int x, y, w, h; int area() const { return w * h; } };
static std::vector<int> some(int n) { std::vector<int> v; for (int i = 0; i < n; i++) v.push_back(i * i); return v; }",
        r#"blob b[3] = {{0, 0, 2, 3}, {1, 1, 4, 5}, {2, 2, 1, 1}}; for (const blob* p = b; p < b + 3; ++p) scamp5_in(A, p->area()); scamp5_in(A, (b + 1)->area()); scamp5_in(A, b->area()); const blob* q = b; scamp5_in(A, q->area()); scamp5_in(A, (*q).area());
std::vector<int> v = {1, 2, 3, 4}; for (auto it = v.rbegin(); it != v.rend(); ++it) scamp5_in(B, *it); for (auto it = v.rbegin(); it < v.rend(); it += 2) *it *= 10; for (int x : v) scamp5_in(B, x); std::sort(v.rbegin(), v.rend()); for (int x : v) scamp5_in(B, x);
for (char c : std::string("ab")) scamp5_in(C, c); std::string t = "xyz"; int n = 0; for (const char& c : t) n += c; scamp5_in(C, n - 300); for (auto c : t) n -= c; scamp5_in(C, n); for (int k : some(4)) scamp5_in(C, k); for (auto k : {5, 6}) scamp5_in(C, k); scamp5_in(C, (int)some(4).size()); scamp5_in(C, some(3).back());"#,
        &[
            6, 20, 1, 20, 6, 6, 6, 4, 3, 2, 1, 1, 20, 3, 40, 40, 20, 3, 1, 97, 98, 63, 0, 0, 1, 4,
            9, 5, 6, 4, 4,
        ],
    );
}

/// What is not supported of classes is told for what it is.
#[test]
fn what_is_not_followed_of_classes_is_named() {
    let base = "struct B { int n = 1; int get() { return n; } };\n";
    told(
        &format!(
            "{base}struct D : B {{ int get() {{ return 2; }} }};\nint main() {{ D d; scamp5_in(A, d.get()); }}"
        ),
        3,
        "`d`, a class whose `get` hides that of its base, which is not `virtual`, in line 2",
        "",
    );
    told(
        &format!("{base}int main() {{ B a; B b;\nscamp5_in(A, (a + b).n); }}"),
        3,
        "`+` between an object of `B` and an object of `B`",
        "define `operator+`",
    );
    told(
        "struct P { int x; };\nint main() { P p = {.y = 2}; scamp5_in(A, p.x); }",
        2,
        "`P` has no member `y`",
        "",
    );
    told(
        "int main() { std::map<int, int> m = {{1, 2}};\nscamp5_in(A, m.at(3)); }",
        2,
        "`at` of the number 3, which is not a key of this map",
        "`count`",
    );
    told(
        "struct S { int n; S& operator+=(int k) { mov(A, B); n += k; return *this; } };\nint main() { S s{1}; s += 2; }",
        1,
        "`operator+=` runs instructions of the array without an explicit call",
        "",
    );
    let text = "int main() { std::unordered_map<int, int> m = {{2, 1}, {1, 2}}; for (auto& it : m) scamp5_in(A, it.first); }";
    let warnings = expand(text).unwrap().warnings;
    let order = "the order of an `unordered_map` is unspecified in C++";
    assert!(
        warnings.iter().any(|it| it.message == order),
        "{warnings:?}"
    );
}

/// Another chip's calls, the GUI's pictures, and one fault for a `switch` that the run decides.
#[test]
fn messages_name_what_is_wrong() {
    told(
        "int main() { while (1) { vs_frame_loop_control();\nscamp7_in(A, 3); } }",
        2,
        "`scamp7_in` is a call of the SCAMP-7, which is not modelled",
        "SCAMP-5",
    );
    told(
        "int main() { while (1) { vs_frame_loop_control();\nvs_gui_request_image(\"a.bmp\", 6, [&](vs_dotmat const& m, int s) { }); mov(A, B); } }",
        2,
        "asks the GUI for a picture",
        "exec --image FILE",
    );
    told(
        "int main() { while (1) { int e = 2;\nscamp5_shift(R5, 1, 0, e); } }",
        2,
        "`scamp5_shift` does not take 4 arguments like these",
        "scamp5_shift(d, h, v, 1)",
    );
    let case = |n| {
        format!(
            "case {n}: scamp5_kernel_begin(); mov(A, B); scamp5_kernel_end(); scamp5_in(C, {n}); break;\n"
        )
    };
    let cases = [1, 2, 3, 4, 5, 6].map(case).concat();
    let text = format!(
        "int main() {{ while (1) {{ vs_frame_loop_control(); switch (scamp5_global_or(R5)) {{ {cases} }} }} }}"
    );
    let faults = expand(&text).unwrap_err().faults;
    assert_eq!(faults.len(), 1, "{faults:#?}");
}

/// What the GUI would send is refused behind the guards that programs have for it.
#[test]
fn what_the_gui_would_send_is_refused() {
    let frame = |inside: &str| {
        format!("int main() {{ while (1) {{ vs_frame_loop_control(); mov(A, B);\n{inside} }} }}")
    };
    let wait = "do { vs_process_message(); } while (!vs_gui_request_done());";
    for guard in [
        "vs_gui_request_done() && vs_gui_is_on()",
        "vs_gui_request_done()",
        "vs_gui_is_on()",
    ] {
        let asks = "vs_gui_request_image(\"a.bmp\", 4, [&](vs_dotmat const& m, int s) { });";
        told(
            &frame(&format!("if ({guard}) {{ {asks} {wait} }}")),
            2,
            "`vs_gui_request_image` asks the GUI for a picture, `a.bmp`, but there is no GUI here",
            "exec --set REGISTER=FILE.npy",
        );
    }
    let asks = "vs_gui_request_file(\"w.bin\", [&](const uint8_t *c, size_t n, size_t m) { });";
    told(
        &frame(&format!("if (vs_gui_request_done()) {{ {asks} {wait} }}")),
        2,
        "`vs_gui_request_file` asks the GUI for a file, `w.bin`, but there is no GUI here",
        "constants",
    );
    // Nothing was asked for: the GUI is done.
    numbers(
        "",
        "if (vs_gui_request_done()) scamp5_in(A, 7); while (!vs_gui_request_done()) { }",
        &[7],
    );
}

/// A buffer that a cast shows as bytes is refused once, with what to write, whichever way it is run.
#[test]
fn casts_of_buffers_say_what_to_write() {
    for inside in [
        "scamp5_scan_areg(A, (uint8_t*)data, 0, 0, 255, 255, 64, 64);\nif (data[0] > 100) { mov(C, B); }",
        "scamp5_scan_events(R5, (uint8_t*)&data[2], 2);\nfor (int i = 0; i < data[1]; i++) { mov(C, B); }",
    ] {
        let text = format!(
            "int main() {{ int32_t data[16]; while (1) {{ vs_frame_loop_control(); get_image(A, F);\n{inside} }} }}"
        );
        let program = Program::read("p.cpp", &text);
        let (device, none) = (Device::scamp5(), Overrides::new());
        let of_run = program.layout(&device, &none).err().unwrap().faults;
        for faults in [expand(&text).unwrap_err().faults, of_run] {
            let [it] = &faults[..] else {
                panic!("{faults:#?}");
            };
            let (message, help) = (&it.fault.message, it.fault.help.as_deref().unwrap());
            assert!(message.contains("writes bytes, but the elements of `data` have another size"));
            assert!(
                help.contains("declare `data` as an array of `uint8_t`"),
                "{help}"
            );
            assert_eq!(it.line, 2);
        }
    }
    // What a cast shows otherwise no run knows.
    let faults = expand(
        "int main() { while (1) { int n[2]; n[0] = scamp5_global_or(R5); uint8_t *b = (uint8_t*)n; if (b[0]) { mov(A, B); } } }",
    )
    .unwrap_err()
    .faults;
    let help = |it: &amacrine::config::Fault| it.help.clone().unwrap_or_default();
    let all = faults.iter().map(|it| help(&it.fault));
    assert!(all.clone().all(|it| !it.contains("`exec`")), "{faults:#?}");
}

/// Who can run a program beside the array is told what is wrong either way, and nothing else.
#[test]
fn what_a_run_decides_is_no_fault_of_a_run() {
    let text = "int main() { while (1) { vs_frame_loop_control(); if (scamp5_global_or(R5)) { mov(A, B); } nonsense(A); } }";
    let program = Program::read("p.cpp", text);
    let faults = program.layout(&Device::scamp5(), &Overrides::new());
    let faults = faults.err().unwrap().faults;
    assert!(
        matches!(&faults[..], [one] if one.fault.message.contains("nonsense")),
        "{faults:#?}"
    );
}

/// A functor runs words where it is called; what only the run knows makes a map unknown as a whole.
#[test]
fn objects_where_only_the_run_decides() {
    told(
        "struct Blur { int n; void operator()(areg_t a) const { for (int i = 0; i < n; i++) movx(a, a, west); } };\n\
         int main() { Blur b{2}; while (1) { vs_frame_loop_control(); int s = scamp5_global_or(R5);\nif (s) b(A); } }",
        3,
        "whether this kernel runs",
        "",
    );
    for inside in [
        "m[3] = 1;",
        "m.erase(1);",
        "m.insert({3, 1});",
        "int k = m[3];",
    ] {
        told(
            &format!(
                "int main() {{ std::map<int, int> m = {{{{1, 2}}}}; while (1) {{ vs_frame_loop_control(); if (scamp5_global_or(R5)) {{ {inside} }}\nscamp5_in(A, m.count(3)); }} }}"
            ),
            2,
            "`scamp5_in` takes a value that depends on `m.count`",
            "",
        );
    }
}

/// What a `switch` leaves beside itself, where only the run knows its case.
#[test]
fn a_switch_of_the_run_may_leave_more_than_itself() {
    told(
        "int main() { while (1) { vs_frame_loop_control(); for (int i = 0; i < 3; i++) { switch (scamp5_global_or(R5)) { case 1: continue; }\nscamp5_in(A, i); } } }",
        2,
        "whether `scamp5_in` runs depends on what `scamp5_global_or` reads",
        "",
    );
    told(
        "void f() { if (scamp5_global_or(R5)) { for (int k = 0; k < 2; k++) { return; } }\nmov(A, B); }\n\
         int main() { while (1) { vs_frame_loop_control(); f(); } }",
        2,
        "whether `mov` runs depends on what `scamp5_global_or` reads",
        "",
    );
    told(
        "int pick(int k) { switch (k) { case 4: return 1; case VS_LED_1: return 5; default: return 2; } }\n\
         int main() { while (1) { vs_frame_loop_control(); scamp5_in(A, pick(4));\nscamp5_in(A, pick(9)); } }",
        3,
        "`scamp5_in` takes a value that depends on `VS_LED_1`",
        "",
    );
}

/// Of an object that changes from frame to frame, only what changes is not known.
#[test]
fn objects_change_from_frame_to_frame() {
    let text = "struct Op { int runs = 0; virtual void run(areg_t a) = 0; };\n\
                struct Shift : Op { int n; Shift(int k) : n(k) {} void run(areg_t a) override { for (int i = 0; i < n; i++) movx(a, a, west); runs++; } };\n\
                int main() { Shift s(2); Op* all[] = {&s}; while (1) { vs_frame_loop_control(); all[0]->run(A); scamp5_in(B, all[0]->runs > -1 ? 3 : 3); } }";
    told(text, 3, "`scamp5_in` takes a value that depends on", "");
    let text = text.replace(
        "scamp5_in(B, all[0]->runs > -1 ? 3 : 3);",
        "scamp5_in(B, s.n);",
    );
    assert_eq!(loaded(&expand(&text).unwrap().code.frame), [2.0]);
    // Who can run it is not refused.
    let text = "struct Op { void run(areg_t a) { mov(a, B); } };\nint main() { Op all[2]; while (1) { vs_frame_loop_control();\nall[scamp5_global_or(R5)].run(A); } }";
    told(text, 3, "what `all.run` runs depends on ", "`exec` runs it");
    let program = Program::read("p.cpp", text);
    assert!(program.layout(&Device::scamp5(), &Overrides::new()).is_ok());
}

/// What is chosen lies where it lay; so does what is assigned.
#[test]
fn chosen_variables_are_themselves() {
    numbers(
        r"struct Base { int v = 1; virtual int f() const { return v; } }; struct More : Base { int f() const override { return 10 + v; } };
int g1 = 1; int g2 = 2; int& pick(bool first) { return first ? g1 : g2; } struct V { int x; V& operator+=(const V& o) { x += o.x; return *this; } V& operator<<(int k) { x = x * 10 + k; return *this; } };",
        r"int a = 3; int b = 2; int& m = a > b ? a : b; m = 100; scamp5_in(A, a); (a < b ? a : b) = 9; scamp5_in(A, b); pick(false) = 7; scamp5_in(A, g2); pick(true) += 4; scamp5_in(A, g1);
More d; More e; e.v = 5; const Base& r = a > b ? d : e; scamp5_in(B, r.f()); e.v = 6; const Base& s = a < b ? d : e; scamp5_in(B, s.f()); const int& c = a > b ? a : 5; a = 1; scamp5_in(B, c); int k = 0; (k = 4) += 3; scamp5_in(B, k);
V v{1}; V w{2}; (v += w) += w; scamp5_in(C, v.x); V& q = (v += w); q.x = 50; scamp5_in(C, v.x); V& u = v << 3; u.x++; scamp5_in(C, v.x - 450);",
        &[100, 9, 7, 5, 11, 16, 100, 7, 5, 50, 54],
    );
}

/// They see what is assigned meanwhile.
#[test]
fn constant_references_are_the_variable() {
    numbers(
        r"struct C { int v; }; const C* act; int g = 1; int both(const int& x) { g = 5; return x; } void keep(const C& c) { act = &c; } int mixed(const long& x) { g = 8; return (int)x; }
struct L { int n; }; std::vector<const L*> ls; void add(const L& l) { ls.push_back(&l); } int sum(const std::vector<int>& all, std::vector<int>& more) { more.push_back(4); int s = 0; for (int x : all) s += x; return s; }",
        r"C c{3}; keep(c); c.v = 4; scamp5_in(A, act->v); scamp5_in(A, both(g)); scamp5_in(A, mixed(g)); L l{1}; add(l); l.n = 6; scamp5_in(A, ls[0]->n); std::vector<int> v{1, 2}; scamp5_in(A, sum(v, v)); scamp5_in(A, both(3)); C all[2] = {{1}, {2}}; keep(all[1]); all[1].v = 9; scamp5_in(A, act->v);",
        &[4, 5, 5, 6, 7, 3, 9],
    );
}

/// What an algorithm adds to the end of an array is there.
#[test]
fn elements_are_added_by_inserters() {
    numbers(
        r"",
        r"int arr[3] = {1, 2, 3}; std::vector<int> o; std::copy(arr, arr + 2, std::back_inserter(o)); scamp5_in(A, (int)o.size()); std::copy_if(arr, arr + 3, std::back_inserter(o), [](int x) { return x > 1; }); for (int x : o) scamp5_in(A, x);
std::vector<uint8_t> q; std::transform(arr, arr + 3, std::back_inserter(q), [](int x) { return x * 100; }); scamp5_in(B, q[2]);
auto [x, y, z] = arr; x = 9; scamp5_in(C, arr[0]); arr[1] = 55; scamp5_in(C, y); auto& [l, m, n] = arr; m = 7; scamp5_in(C, arr[1]); scamp5_in(C, x + z);",
        &[2, 1, 2, 2, 3, 44, 1, 2, 7, 12],
    );
}

/// In the order of the class, anew for each object.
#[test]
fn members_begin_in_their_order() {
    numbers(
        r"int next = 0; int count() { return ++next; } struct Node; struct Tag { int id = count(); int w; int h = w * 2; Tag(int a) : w(a) {} Tag() : w(3) { h++; } Tag(int a, int b) : Tag(a) { h += b; } };
struct Turn { int a; int b; int c; Turn() : c(count()), a(count()), b(count()) {} }; int level = 4; struct Late { int x = level; int y = x + 1; }; struct Node { Node* next; int v; };",
        r"Tag a(5); Tag b; Tag c(1, 2); scamp5_in(A, a.id * 40 + a.w * 10 + a.h); scamp5_in(A, b.id * 40 + b.w * 10 + b.h); scamp5_in(A, c.id); scamp5_in(A, c.h); Tag all[2]; scamp5_in(A, all[1].id); Turn t; scamp5_in(B, t.a * 10 + t.b - t.c);
level = 7; Late l; scamp5_in(B, l.x * 10 + l.y); Node n{0, 3}; Node p{&n, 4}; scamp5_in(B, p.next->v);",
        &[100, 117, 3, 4, 5, 59, 78, 3],
    );
}

/// By reference, or for themselves.
#[test]
fn lambdas_have_what_they_took() {
    numbers(
        r"struct S { int k = 3; int run() { auto f = [*this](int x) { return x * k; }; k = 9; return f(2) + k; } int seen() { auto f = [this](int x) { return x * k; }; k = 5; return f(2); } };
std::function<int()> counter(int s) { return [s]() mutable { return s++; }; } int twice(std::function<int()> f) { return f() * 10 + f(); }",
        r"S s; scamp5_in(A, s.run()); scamp5_in(A, s.seen()); int b = 1; auto j = [&z = b] { z = 40; }; j(); scamp5_in(A, b); std::vector<int> v{1}; auto m = [&w = v] { w.push_back(2); }; m(); scamp5_in(A, (int)v.size());
auto c = counter(5); c(); auto d = c; scamp5_in(B, c()); scamp5_in(B, c()); scamp5_in(B, d()); auto l = [n = 0]() mutable { return ++n; }; l(); scamp5_in(B, twice(l)); scamp5_in(B, l()); std::function<int()> f = l; f(); scamp5_in(B, l());",
        &[15, 10, 40, 2, 6, 7, 6, 23, 2, 3],
    );
}

/// What cannot be followed is told, not passed over.
#[test]
fn what_objects_change_that_are_not_followed() {
    let class = "int g = 1; template <class T> struct Log { void add(int& x, int y) { g = 3; x = 4; } };\nint main() { Log<int> l; int a = 1; int b = 2; l.add(a, b);\n";
    for (inside, line) in [("scamp5_in(A, g); }", 3), ("scamp5_in(A, a); }", 3)] {
        told(&format!("{class}{inside}"), line, "not supported", "");
    }
    numbers(
        "template <class T> struct Log { int n; void add(int& x, int y) { x = 4; } };",
        "Log<int> l; int a = 1; int b = 2; l.add(a, b); scamp5_in(A, b);",
        &[2],
    );
    told(
        "struct T { int n; T(int n) : n(n) {} T(const T& it) : n(it.n + 1) {} };\nint main() { T a(3); T b = a;\nscamp5_in(A, b.n); }",
        3,
        "a class with a copy constructor in line 1",
        "",
    );
    told(
        "int main() { std::vector<int> a{1, 2}; std::vector<int> o;\nstd::merge(a.begin(), a.end(), a.begin(), a.end(), std::back_inserter(o)); if (o.empty())\nscamp5_in(A, 1); }",
        2,
        "depends on",
        "",
    );
}

/// `auto` of a reference is of its type, and a cast finds what an object is.
#[test]
fn a_reference_names_a_part() {
    numbers(
        r"struct A0 { int v = 1; virtual int id() const { return v; } virtual int at() { return 4; } }; struct A1 : A0 { int id() const override { return 100; } }; struct A2 : A0 { int id() const override { return 50; } };
int part(const A0& a) { auto x = a; return x.id() + a.id(); } int what(A0* p) { if (dynamic_cast<A1*>(p)) return 1; return dynamic_cast<A2*>(p) == nullptr ? 0 : 2; }",
        r"A1 a; A2 b; A0 c; A0& r = a; auto x = r; scamp5_in(A, x.id()); scamp5_in(A, r.id()); scamp5_in(A, part(b)); scamp5_in(A, what(&a)); scamp5_in(A, what(&b)); scamp5_in(A, what(&c)); auto y = a; scamp5_in(A, y.id());",
        &[1, 100, 51, 1, 2, 0, 100],
    );
}

/// By the type, also of a character in a text.
#[test]
fn functions_are_chosen_by_what_is_given() {
    numbers(
        r"int w(char) { return 1; } int w(int) { return 2; } struct X { int a; }; struct Y { int b; }; int p(X*) { return 1; } int p(Y*) { return 2; } template <class T> int seen(T x) { static int n = 0; return ++n; }",
        r#"std::string st = "q"; int n = 1; Y y{2}; scamp5_in(A, w("abc"[0])); scamp5_in(A, w(st[0])); scamp5_in(A, w(n)); scamp5_in(A, p(&y)); uint8_t a = 200; uint8_t b = 7; auto m = std::max(a, b); m += 100; scamp5_in(A, m); seen(1); scamp5_in(A, seen(2)); scamp5_in(A, seen(2.5));"#,
        &[1, 1, 2, 2, 44, 2, 1],
    );
}

/// Where which function is meant hangs on what is not told apart.
#[test]
fn what_is_not_told_apart_is_refused() {
    told(
        "struct X { int v; }; int f(X&) { return 1; } int f(const X&) { return 2; } X x{1};\nint main() {\nscamp5_in(A, f(x)); }",
        3,
        "the call of `f` is ambiguous",
        "",
    );
    told(
        "struct B { virtual int f(int a = 1) { return a; } }; struct D : B { int f(int a = 2) override { return a; } };\nint main() { D d; B* p = &d;\nscamp5_in(A, p->f()); }",
        3,
        "other default arguments",
        "",
    );
    told(
        "struct B { virtual int g() const { return 1; } }; struct D : B { int g() { return 2; } };\nint main() { D d; const B* p = &d;\nscamp5_in(A, p->g()); }",
        3,
        "hides that of its base",
        "",
    );
}

/// Each `template<int N>` has its own variables that are made once, as has each class.
#[test]
fn templates_have_variables_of_their_own() {
    numbers(
        "template<int N> int from() { static int n = N; return ++n; } struct V { int x; }; struct W { int y; };
template<typename T> int tick(T x) { static int n = 0; return ++n; }",
        "scamp5_in(A, from<1>()); scamp5_in(A, from<10>()); scamp5_in(A, from<1>()); scamp5_in(A, from<10>());
scamp5_in(B, tick(1)); scamp5_in(B, tick(1.0)); scamp5_in(B, tick(2)); V v; W w; scamp5_in(C, tick(v)); scamp5_in(C, tick(w)); scamp5_in(C, tick(v));",
        &[2, 11, 3, 12, 1, 1, 2, 1, 1, 2],
    );
    told(
        "struct V { int x; }; struct W { int y; };\ntemplate<typename T> int tick() { static int n = 0; return ++n; }\nint main() { scamp5_in(A, tick<V>()); }",
        2,
        "which `n` this is",
        "a global variable",
    );
}

/// Of a number, or of an enumeration.
#[test]
fn overloads_tell_enumerations_from_numbers() {
    let before = "enum E { P = 3, Q }; enum class F : uint8_t { X, Y = 5 }; struct H { E e; };
void f(E e) { scamp5_in(A, 10 + e); }\nvoid f(int e) { scamp5_in(A, 100 + e); }
void g(F e) { scamp5_in(B, 10 + (int)e); }\nvoid g(int e) { scamp5_in(B, 100 + e); }
void l(E e) { scamp5_in(C, 1); }\nvoid l(F e) { scamp5_in(C, 2); }\nvoid m(E e) { scamp5_in(D, 1); }\nvoid m(float e) { scamp5_in(D, 2); }
template<typename T> void give(T t) { f(t); }";
    numbers(
        before,
        "f(P); f(3); f(P + 1); int x = P; f(x); E e = Q; f(e); f((int)e); E* p = &e; f(*p); E all[2] = {P, Q}; f(all[1]); auto a = P; f(a); auto b = 3; f(b); give(P); give(3); f(e = P);
g(F::X); g(5); F y = F::Y; g(y); g((int)y); l(P); l(F::X); l(e); m(P); m(2);",
        &[
            13, 103, 104, 103, 14, 104, 14, 14, 13, 103, 13, 103, 13, 10, 105, 15, 105, 1, 2, 1, 1,
            2,
        ],
    );
    for unclear in ["f((E)3)", "H h; f(h.e)", "auto a = E(3); f(a)"] {
        let text = format!("{before}\nint main() {{ {unclear}; }}");
        told(
            &text,
            11,
            "the call of `f` is ambiguous",
            "cast the arguments",
        );
    }
}

/// By what a pointer leads to, whether a value lies there or not.
#[test]
fn overloads_tell_pointers_apart() {
    numbers(
        "void f(int* p) { scamp5_in(A, 1); }\nvoid f(const char* p) { scamp5_in(A, 2); }\nstruct S { int x; int a[2]; char c[3]; };
void g(float* p) { scamp5_in(B, 1); }\nvoid g(int* p) { scamp5_in(B, 2); }\nvoid g(uint8_t* p) { scamp5_in(B, 3); }",
        "int a[2] = {1, 2}; int* q = a; int x; f(a); f(\"x\"); f(q); f(&x); char c[3]; f(c); f(new int[3]); f(new char[3]); S s; f(s.a); f(s.c); f(&s.x); int b[2][2]; f(b[1]); int** pp = &q; f(*pp); std::vector<char> v(3); f(v.data());
float r[2]; g(r); g(a); uint8_t u[2]; g(u);",
        &[1, 2, 1, 1, 2, 1, 2, 1, 2, 1, 1, 1, 2, 1, 2, 3],
    );
}

/// What only the run knows: how long an array is, which variable is changed.
#[test]
fn what_the_run_decides_is_not_taken_for_known() {
    let within = |before: &str, inside: &str| {
        format!(
            "{before}\nint main() {{ while (1) {{ vs_frame_loop_control(); int n = scamp5_global_sum_fast(A);\n{inside}\n}} }}"
        )
    };
    let inc = "void inc(int& x) { x += 1; }";
    for (before, inside, message) in [
        (
            "",
            "std::vector<int> v(n); scamp5_in(B, v.size());",
            "depends on `v.size`",
        ),
        (
            "",
            "int k[n]; for (int x : k) scamp5_in(B, 7);",
            "how often this loop runs",
        ),
        (
            "",
            "std::vector<int> v; for (int i = 0; i < n; i++) v.push_back(i); scamp5_in(B, v.size());",
            "depends on `v.size`",
        ),
        (
            "",
            "std::vector<int> v; if (n > 3) v = {1, 2}; scamp5_in(B, v.size());",
            "depends on `v.size`",
        ),
        (
            "",
            "int m = -1; std::vector<int> v(m);",
            "an array of -1 elements",
        ),
        (
            inc,
            "int a = 1, b = 5; inc(n > 3 ? a : b); scamp5_in(B, a);",
            "which variable `inc` changes",
        ),
        (
            inc,
            "int a[2] = {1, 2}; inc(a[n]); scamp5_in(B, a[0]);",
            "takes a value",
        ),
        (
            "",
            "int a = 1, b = 2; int* p = &a; if (n > 3) p = &b; *p = 7; scamp5_in(B, a);",
            "takes a value",
        ),
        (
            "",
            "int a = 1, b = 2; int* p = n > 3 ? &a : &b; a = 4; *p = 7; scamp5_in(B, a);",
            "takes a value",
        ),
        (
            "",
            "int a[3] = {1, 2, 3}; int* p = a; p += n; *p = 7; scamp5_in(B, a[0]);",
            "takes a value",
        ),
        (
            "",
            "areg_t r = A; if (n > 3) r = B; mov(C, r);",
            "depends on",
        ),
        (
            "int a, b; int* pick(int n) { if (n > 3) return &a; return &b; }",
            "b = 2; *pick(n) = 7; scamp5_in(B, b);",
            "depends on",
        ),
        (
            "struct P { int x; void set(int k) { x = k; } };",
            "P a{1}, b{2}; (n > 3 ? a : b).set(7); scamp5_in(B, a.x);",
            "depends on",
        ),
    ] {
        told(&within(before, inside), 3, message, "");
    }
}

/// An object in an array or in another object has operators too.
#[test]
fn operators_of_inner_objects_are_not_passed_over() {
    let classes = "struct K { int v; bool operator==(const K& o) const { return v % 10 == o.v % 10; } };
struct V { int x; V& operator=(const V& o) { x = o.x + 1; return *this; } }; struct H { V v; int k; };";
    for (inside, operator) in [
        (
            "std::pair<K, int> p{{1}, 2}, q{{11}, 2}; scamp5_in(A, p == q);",
            "operator==",
        ),
        (
            "std::vector<K> a = {{1}}, b = {{11}}; scamp5_in(A, a == b);",
            "operator==",
        ),
        ("H a{{1}, 2}, b{{5}, 6}; a = b;", "operator="),
        ("std::vector<V> a = {V{1}}, b; b = a;", "operator="),
        ("V a{1}, b{2}; std::swap(a, b);", "operator="),
    ] {
        let text = format!("{classes}\nint main() {{\n{inside}\n}}");
        told(&text, 4, &format!("`{operator}` of"), "one by one");
    }
    // What is sorted or filled is not known then.
    let text = format!(
        "{classes}\nint main() {{\nV v[2]; V a{{3}}; std::fill(v, v + 2, a); scamp5_in(A, v[1].x);\n}}"
    );
    told(&text, 4, "what `fill` does", "");
}

/// `p->Base::name()` is that of the base; objects are sorted by the `<` of their class.
#[test]
fn functions_of_a_base_are_called_by_its_name_and_objects_sorted() {
    numbers(
        "struct Base { int v = 3; virtual int f() { return 1; } int g() { return v; } }; struct More : Base { int f() override { return 2; } };
struct K { int v; bool operator<(const K& o) const { return v > o.v; } }; struct J { int v; }; bool operator<(const J& a, const J& b) { return a.v < b.v; }",
        "More d; More* p = &d; scamp5_in(A, p->f()); scamp5_in(A, p->Base::f()); scamp5_in(A, d.Base::f()); scamp5_in(A, p->Base::g()); scamp5_in(A, p->Base::v);
std::vector<K> k = {{1}, {13}, {2}}; std::sort(k.begin(), k.end()); for (auto& it : k) scamp5_in(B, it.v); J j[3] = {{3}, {1}, {2}}; std::sort(j, j + 3); for (auto& it : j) scamp5_in(C, it.v);",
        &[2, 1, 1, 3, 3, 13, 2, 1, 1, 2, 3],
    );
}

/// A number becomes one of an enumeration, of the bits that this has.
#[test]
fn casts_to_enumerations() {
    numbers(
        "enum Mode { IDLE, RUN = 5, STOP }; enum class Dir : uint8_t { N = 1, E = 2 }; typedef enum { LOW, HIGH = 7 } Level; using Other = Mode;
struct Light { enum Phase { RED, GREEN }; Phase at = (Phase)0; void next() { at = (Phase)((at + 1) % 2); } };",
        "int x = 2; Mode m = (Mode)(x + 1); scamp5_in(A, m); m = Mode(STOP - 1); scamp5_in(A, m); m = static_cast<Mode>((x + 3) % 7); scamp5_in(A, m); if ((Mode)(m + 1) == STOP) scamp5_in(A, 1);
switch (Mode(x + 3)) { case RUN: scamp5_in(A, 2); break; default: scamp5_in(A, 3); } for (int i = 0; i < 2; i++) m = (Mode)(m + 1); scamp5_in(A, m);
Dir d = Dir(x); scamp5_in(B, (int)d); d = (Dir)(x + 299); scamp5_in(B, (int)d); scamp5_in(B, Dir(x) == Dir::E); Level l = (Level)(x * 3 + 1); scamp5_in(B, l == HIGH); scamp5_in(B, HIGH); Other o = (Other)(x - 1); scamp5_in(B, o);
m = (Mode)2.9f; scamp5_in(C, m); Light t; t.next(); scamp5_in(C, t.at); m = Mode{RUN}; scamp5_in(C, m);",
        &[3, 5, 5, 1, 2, 7, 2, 45, 1, 1, 7, 1, 2, 1, 5],
    );
}

/// Of arrays, of pointers and of vectors a template takes the type of the elements.
#[test]
fn types_are_taken_from_elements() {
    numbers(
        "template<typename T, int N> T mean(const T(&a)[N]) { T s = 0; for (int i = 0; i < N; i++) s += a[i]; return s / N; } template<typename T> T sum(const T* a, int n) { T s = 0; for (int i = 0; i < n; i++) s += a[i]; return s; }
template<typename T> T all(const std::vector<T>& v) { T s = 0; for (auto x : v) s += x; return s / (int)v.size(); } template<typename T> int bytes(T* p) { return sizeof(T); }",
        "float f[3] = {1, 2, 4}; uint8_t u[4] = {200, 200, 200, 200}; double d[2] = {.5, .25}; scamp5_in(A, (int)(mean(f) * 10)); scamp5_in(A, mean(u)); scamp5_in(A, (int)(sum(f, 3) * 10)); scamp5_in(A, sum(u, 4)); scamp5_in(A, sum(u + 1, 2) - 100); scamp5_in(A, (int)(sum(d, 2) * 100));
std::vector<float> w = {1, 2, 4}; std::vector<uint8_t> b = {200, 200}; scamp5_in(B, (int)(all(w) * 10)); scamp5_in(B, all(b)); scamp5_in(B, bytes(d)); scamp5_in(B, bytes(u)); uint8_t* p = u; scamp5_in(B, sum(p, 3));
auto more = [](auto x) { x += 100; return x; }; auto half = [](auto x) { auto h = x; h /= 2; return h; }; scamp5_in(C, more(u[0])); scamp5_in(C, more(7)); scamp5_in(C, (int)(half(2.5f) * 100)); scamp5_in(C, more((uint8_t)200));
auto total = [](const auto& v) { auto s = v[0]; for (size_t i = 1; i < v.size(); i++) s += v[i]; return s; }; scamp5_in(C, total(b) - 100); scamp5_in(C, (int)(total(w) * 10));",
        &[23, 8, 70, 32, 44, 75, 23, 72, 8, 1, 88, 44, 107, 125, 44, 44, 70],
    );
}

/// What is chosen is of the type that is asked for; `auto` is of the type of an element.
#[test]
fn the_library_keeps_types() {
    numbers(
        "struct S { uint8_t m = 250; uint8_t get() const { return m; } };",
        "scamp5_in(A, std::min<int>(255, 3.7f)); scamp5_in(A, std::max<uint8_t>(200 + 100, 10)); scamp5_in(A, 7 / std::max<int>(2.9, 1)); scamp5_in(A, (int)(std::max<float>(1, 2) / 4 * 10)); scamp5_in(A, std::clamp<uint8_t>(300, 0, 255)); scamp5_in(A, std::max<int>({1.9, 3.9, 2}));
std::vector<uint8_t> v = {250, 3}; uint8_t a[3] = {250, 1, 2}; uint8_t ten = 10; scamp5_in(B, std::accumulate(a, a + 3, ten)); scamp5_in(B, std::accumulate(v.begin(), v.end(), 0) - 200);
auto x1 = v.front(); x1 += 10; auto x2 = *v.begin(); x2 += 10; auto x3 = v.at(0); x3 += 10; auto x4 = *std::max_element(a, a + 3); x4 += 10; scamp5_in(C, x1); scamp5_in(C, x2); scamp5_in(C, x3); scamp5_in(C, x4);
std::pair<uint8_t, int> p = {250, 1}; auto x5 = std::get<0>(p); x5 += 10; std::map<int, uint8_t> m; m[1] = 250; auto x6 = m.at(1); x6 += 10; auto x7 = m[1]; x7 += 10; auto x8 = m.begin()->second; x8 += 10; S s; auto x9 = s.get(); x9 += 10; auto y = *v.rbegin(); y += 254; scamp5_in(D, x5); scamp5_in(D, x6); scamp5_in(D, x7); scamp5_in(D, x8); scamp5_in(D, x9); scamp5_in(D, y);
std::vector<float> w = {3, 4}; auto z = *w.begin(); z = 1; z /= 4; scamp5_in(D, (int)(z * 100)); int few[2] = {1, 2}; auto q = few[1]; q = 2.9; scamp5_in(D, q);",
        &[
            3, 44, 3, 5, 44, 3, 7, 53, 4, 4, 4, 4, 4, 4, 4, 4, 4, 1, 25, 2,
        ],
    );
}

/// Where objects change others when they end, or by their members, it is said.
#[test]
fn objects_that_change_others_are_refused() {
    for (class, inside) in [
        ("struct E { E() { n++; } ~E() { n--; } };", "E e;"),
        ("struct E { int* p; ~E() { (*p)--; } };", "E e{&n};"),
    ] {
        let text = format!("int n = 0;\n{class}\nint main() {{ {inside} }}");
        told(
            &text,
            2,
            "the destructor of `E` changes",
            "at the end of the object's lifetime",
        );
    }
    for (class, inside) in [
        (
            "struct I { int& n; I(int& k) : n(k) {} void go() { n++; } };",
            "I a(total);",
        ),
        ("struct I { int& n; };", "I a{total};"),
    ] {
        let text = format!("int total = 0;\n{class}\nint main() {{\n{inside} }}");
        told(
            &text,
            4,
            "a class with a reference as a member",
            "a pointer",
        );
    }
    numbers(
        "int n = 3; struct B { int k = 1; int* p; B() { p = new int[4]; } ~B() { delete[] p; p = nullptr; k = 0; } };",
        "B b; scamp5_in(A, b.k); scamp5_in(A, n);",
        &[1, 3],
    );
}

/// A variable that is made once, in a function that the run may call from the second frame on.
#[test]
fn variables_that_are_made_once_in_a_later_frame() {
    let text = "int f(int x) { static int8_t n = 0; n++; return n + x; }\nint main() { int a = 3, b = 0, c = 3; while (1) { vs_frame_loop_control();\nc = c * 3 % 7; if (c == 2) { a = 1; } else { a = 2; }\nb = a > 5 || f(c); scamp5_in(A, 1); } }";
    assert_eq!(loaded(&expand(text).unwrap().code.frame), [1.0]);
    let text = "template<typename T> T t(T x) { return x; } int f(double x) { static int8_t n = 0; n++; return n + x; }\nint main() { int a = 3, b = 0, c = 3; while (1) { vs_frame_loop_control();\nc = c * 3 % 7; if (t(c)) { a = 1; } else { a = 2; }\nb = a || f(c); scamp5_in(A, 1); } }";
    assert_eq!(loaded(&expand(text).unwrap().code.frame), [1.0]);
}

/// The limits of types, by the language's template and by its constants.
#[test]
fn limits_of_types() {
    numbers(
        "template<typename T> int top(T x) { return (int)std::numeric_limits<T>::max(); } template<typename T> T least() { return std::numeric_limits<T>::lowest(); }",
        "scamp5_in(A, std::numeric_limits<uint8_t>::max() - 200); scamp5_in(A, std::numeric_limits<int8_t>::min()); scamp5_in(A, std::numeric_limits<int16_t>::max() - 32700); scamp5_in(A, std::numeric_limits<int>::max() - 2147483600); scamp5_in(A, std::numeric_limits<int>::min() + 2147483600);
auto m = std::numeric_limits<uint8_t>::max(); m++; scamp5_in(B, m); scamp5_in(B, std::numeric_limits<unsigned>::max() == 4294967295u); scamp5_in(B, std::numeric_limits<float>::max() == FLT_MAX); scamp5_in(B, std::numeric_limits<float>::lowest() < -1e38f); scamp5_in(B, std::numeric_limits<float>::infinity() > FLT_MAX); scamp5_in(B, std::numeric_limits<double>::epsilon() < 1e-15); scamp5_in(B, sizeof(std::numeric_limits<uint16_t>::max())); scamp5_in(B, std::numeric_limits<uint8_t>::is_signed); scamp5_in(B, std::numeric_limits<int8_t>::digits);
uint8_t u = 3; int8_t s = 3; scamp5_in(C, top(u) - 200); scamp5_in(C, top(s)); scamp5_in(C, least<int8_t>()); scamp5_in(C, CHAR_BIT); scamp5_in(C, UINT64_MAX == 18446744073709551615u); scamp5_in(C, FLT_MIN > 0 && FLT_MIN < 1e-30); scamp5_in(C, INFINITY > FLT_MAX);",
        &[
            55, -128, 67, 47, -48, 0, 1, 1, 1, 1, 1, 2, 0, 7, 55, 127, -128, 8, 1, 1, 1,
        ],
    );
}

/// Of a reference to an array in several dimensions, without a name too, and of `std::array`.
#[test]
fn templates_take_the_lengths_of_arrays() {
    numbers(
        "template <typename T, size_t N> int total(const std::array<T, N>& a) { int s = 0; for (size_t i = 0; i < N; i++) s += a[i]; return s + N; } template <typename T, size_t N> constexpr size_t len(T (&)[N]) { return N; }
template <typename T, size_t R, size_t C> int sum(const T (&a)[R][C]) { int s = 0; for (size_t i = 0; i < R; i++) for (size_t j = 0; j < C; j++) s += a[i][j] * (int)(i + 1); return s; }
template <typename T> int bytes(const std::vector<T>& v) { return sizeof(T) * 10 + v.size(); } template <typename T> T whole(std::vector<T> v) { T s = 0; for (auto x : v) s += x; return s; }",
        "std::array<int, 4> a = {1, 2, 3, 4}; scamp5_in(A, total(a)); int c[5] = {1}; scamp5_in(A, len(c)); int d[2][3] = {{1, 2, 3}, {4, 5, 6}}; scamp5_in(A, sum(d));
scamp5_in(B, bytes(std::vector<uint8_t>(4))); scamp5_in(B, bytes(std::vector<uint16_t>{1, 2})); scamp5_in(B, whole(std::vector<uint8_t>{200, 100})); scamp5_in(B, (int)(2 * whole(std::vector<float>{1, .5}))); auto v = std::vector<uint8_t>{250, 1}; v[0] += 10; scamp5_in(B, v[0]);
std::vector<int> w = {4, 5, 6}; std::vector<int> x(w); x[0] = 9; scamp5_in(C, w[0]); scamp5_in(C, x[0]); std::vector<int> y(w.begin() + 1, w.end()); scamp5_in(C, (int)y.size()); scamp5_in(C, y[0]); int (*row)[3]; row = d; scamp5_in(C, row[1][2]);",
        &[14, 5, 36, 14, 22, 44, 3, 4, 4, 9, 2, 5, 6],
    );
}

/// What moves, finds and sums by what a function says, and by order.
#[test]
fn algorithms_go_by_functions_and_order() {
    numbers(
        "struct Box { int x; int w; }; bool odd(int x) { return x & 1; } bool wide(const Box& p, const Box& q) { return p.w > q.w; }",
        "std::vector<int> v = {5, 3, 8, 3, 1, 9, 3}; v.erase(std::remove_if(v.begin(), v.end(), [](int x) { return x > 7; }), v.end()); scamp5_in(A, (int)v.size()); v.erase(std::remove(v.begin(), v.end(), 3), v.end()); for (int x : v) scamp5_in(A, x);
v = {5, 3, 8, 3, 1, 9, 3}; std::sort(v.begin(), v.end()); v.erase(std::unique(v.begin(), v.end()), v.end()); for (int x : v) scamp5_in(A, x);
scamp5_in(B, std::lower_bound(v.begin(), v.end(), 5) - v.begin()); scamp5_in(B, std::upper_bound(v.begin(), v.end(), 5) - v.begin()); scamp5_in(B, std::lower_bound(v.begin(), v.end(), 100) == v.end()); scamp5_in(B, std::binary_search(v.begin(), v.end(), 8)); scamp5_in(B, std::count_if(v.begin(), v.end(), odd)); scamp5_in(B, std::any_of(v.begin(), v.end(), [](int x) { return x > 8; })); scamp5_in(B, std::all_of(v.begin(), v.end(), odd)); auto it = std::find_if(v.begin(), v.end(), [](int x) { return x > 5; }); scamp5_in(B, *it); scamp5_in(B, std::distance(v.begin(), it)); scamp5_in(B, *std::next(v.begin(), 2)); scamp5_in(B, *std::prev(v.end()));
Box b[3] = {{1, 4}, {2, 9}, {3, 2}}; scamp5_in(C, std::max_element(b, b + 3, [](const Box& p, const Box& q) { return p.w < q.w; })->x); scamp5_in(C, std::min_element(b, b + 3, [](const Box& p, const Box& q) { return p.w < q.w; }) - b); scamp5_in(C, std::accumulate(b, b + 3, 1, [](int s, const Box& p) { return s + p.w; })); int p[3] = {1, 2, 3}, q[3] = {4, 5, 6}; scamp5_in(C, std::inner_product(p, p + 3, q, 1)); std::replace(p, p + 3, 2, 50); scamp5_in(C, p[1]); scamp5_in(C, std::equal(p, p + 3, q)); int n = 7; std::generate(q, q + 3, [&n] { return n++; }); scamp5_in(C, q[2]);
std::sort(b, b + 3, wide); scamp5_in(D, b[0].x); std::vector<int> w = {1, 2}; w.insert(w.end(), {8, 9}); w.insert(w.begin(), p, p + 2); scamp5_in(D, (int)w.size()); scamp5_in(D, w[1]); scamp5_in(D, w[5]); int calls = 0; std::any_of(w.begin(), w.end(), [&](int x) { calls++; return x == 50; }); scamp5_in(D, calls);",
        &[
            5, 5, 1, 1, 3, 5, 8, 9, 2, 3, 1, 1, 4, 1, 0, 8, 3, 5, 9, 2, 2, 16, 33, 50, 0, 9, 2, 6,
            50, 9, 2,
        ],
    );
}

/// Pointers to characters go over a text; characters are added to a `std::string`.
#[test]
fn pointers_go_over_texts() {
    numbers(
        "int length(const char* s) { const char* p = s; while (*p) p++; return p - s; } int number(const char* s) { int v = 0; while (*s >= '0' && *s <= '9') v = v * 10 + (*s++ - '0'); return v; } int count(const char* s, char c) { int n = 0; for (; *s; ++s) if (*s == c) n++; return n; }",
        r#"scamp5_in(A, length("hello")); scamp5_in(A, number("42x")); scamp5_in(A, count("banana", 'a')); const char* c = "abc"; const char* d = c + 1; scamp5_in(A, *d); scamp5_in(A, d[1]); scamp5_in(A, d - c); scamp5_in(A, c - d); scamp5_in(A, *(c + 3)); int8_t one = 1; scamp5_in(A, *(c + one)); scamp5_in(A, sizeof(*c)); scamp5_in(A, sizeof(d[1])); scamp5_in(A, sizeof(*(c + 1))); scamp5_in(A, sizeof((1 + c)[1])); if (*d == 'b') scamp5_in(A, 5);
scamp5_in(B, strcmp("a", "b") < 0); scamp5_in(B, strcmp("ab", "ab")); scamp5_in(B, strncmp("abc", "abd", 2)); scamp5_in(B, strchr("hello", 'l') - "hello" >= 0); scamp5_in(B, strchr("hello", 'z') == nullptr); scamp5_in(B, toupper('b')); scamp5_in(B, isdigit('5') != 0); scamp5_in(B, atoi("42")); scamp5_in(B, __builtin_popcount(0xF0F)); scamp5_in(B, __builtin_ctz(8));
std::string s = "x"; s += 'y'; s += "z"; s = '<' + s + '!'; scamp5_in(C, s == "<xyz!"); scamp5_in(C, (int)s.size()); s.push_back('q'); scamp5_in(C, s.back()); scamp5_in(C, s.substr(1, 3) == "xyz"); scamp5_in(C, (int)s.find("yz")); scamp5_in(C, s.find('w') == std::string::npos);"#,
        &[
            5, 42, 3, 98, 99, 1, -1, 0, 98, 1, 1, 1, 1, 5, 1, 0, 0, 1, 1, 66, 1, 42, 8, 3, 1, 5,
            113, 1, 2, 1,
        ],
    );
}

/// A pointer may stand behind the end of a text, as long as nothing hangs on it.
#[test]
fn pointers_stand_behind_a_text() {
    numbers(
        "",
        r#"const char* p = "abc"; int n = 0; while (*p++) n++; scamp5_in(A, n); char d[8]; char* q = d; const char* s = "hey"; while ((*q++ = *s++)); scamp5_in(A, d[2]); scamp5_in(A, d[3]); scamp5_in(A, (int)strlen(d));"#,
        &[3, 121, 0, 3],
    );
    told(
        "int main() { const char* p = \"abc\"; while (*p++); if (*p) mov(A, B); }",
        1,
        "a pointer behind the end of its text",
        "",
    );
    told(
        "int main() { const char* p = \"abc\"; p += 5; mov(A, B); }",
        1,
        "past the end of the string",
        "",
    );
}

/// Arrays of characters end with a 0, and hold what is written into them.
#[test]
fn arrays_of_characters_hold_texts() {
    numbers(
        "",
        r#"char line[16]; int n = sprintf(line, "v=%d", 42); scamp5_in(A, n); scamp5_in(A, (int)strlen(line)); scamp5_in(A, line[2]); scamp5_in(A, line[4]); scamp5_in(A, snprintf(line, 4, "%d", 123456)); scamp5_in(A, (int)strlen(line)); strcpy(line, "abc"); strcat(line, "de"); scamp5_in(A, strcmp(line, "abcde")); strncpy(line, "zz", 2); scamp5_in(A, line[1] == 'z' && line[2] == 'c'); scamp5_in(A, atoi(line + 5));
char lit[] = "xyz"; scamp5_in(B, sizeof(lit)); scamp5_in(B, lit[3]); for (char* p = lit; *p; p++) *p = *p - 32; scamp5_in(B, lit[0]); std::string s = lit; scamp5_in(B, s == "XYZ");"#,
        &[4, 4, '4' as i32, 0, 6, 3, 0, 1, 0, 4, 0, 88, 1],
    );
    told(
        "int main() { char line[4];\nsprintf(line, \"%d\", 12345); scamp5_in(A, 1); }",
        2,
        "`sprintf` writes 6 characters with the terminating 0, but the buffer has room for 4",
        "a larger array",
    );
    for (format, values) in [
        ("%.*f", "100000, 0.1"),
        ("%100000f", "0.1"),
        ("%.100000e", "0.1"),
        ("%.100000g", "0.1"),
        ("%2000000d", "1"),
        ("%-99999999999999999999s", "\"a\""),
    ] {
        told(
            &format!(
                "int main() {{ char b[10];\nsnprintf(b, 10, \"{format}\", {values}); scamp5_in(A, b[0]); }}"
            ),
            2,
            "a width or a precision of more than 4096 characters",
            "a smaller one",
        );
    }
    numbers(
        "",
        r#"char b[5000]; scamp5_in(A, sprintf(b, "%4096.4000f", 0.5) == 4096);"#,
        &[1],
    );
    told(
        "int main() { const char* p = \"ab\";\np += 3; scamp5_in(A, *p); }",
        2,
        "past the end of the string",
        "no further than `strlen` returns",
    );
}

/// Each row has the bytes of its text, a 0, and more of those up to its length; what stands behind
/// it in braces is the next member.
#[test]
fn rows_of_characters_are_texts() {
    numbers(
        r##"const char glyph[3][4] = {"#.#", ".#.", "#.#"}; const char names[][8] = {"ab", "cde", "f"}; char one[8] = {"abc"}; const char wide[8] = "hey";
struct Step { char name[8]; int shifts; }; const Step steps[2] = {{"right", 3}, {"more", 2}}; struct Tag { char text[4] = "dd"; int n = 1; };"##,
        r#"int set = 0; for (int r = 0; r < 3; r++) for (int c = 0; c < 3; c++) if (glyph[r][c] == '#') set = set * 10 + 3 * r + c; scamp5_in(A, set / 100); scamp5_in(A, set % 100); scamp5_in(A, glyph[1][3]);
scamp5_in(A, sizeof(names) / sizeof(names[0])); scamp5_in(A, (int)strlen(names[1])); scamp5_in(A, strcmp(names[2], "f")); scamp5_in(A, (int)strlen(one)); scamp5_in(A, one[2]); scamp5_in(A, one[7]); scamp5_in(A, sizeof(wide)); scamp5_in(A, (int)(strchr(wide, 'y') - wide));
for (auto& it : steps) { scamp5_in(B, it.shifts); scamp5_in(B, (int)strlen(it.name)); scamp5_in(B, it.name[1]); } Step by = {"x"}; scamp5_in(B, by.shifts); by = {"long", 7}; scamp5_in(B, by.name[3]); scamp5_in(B, by.shifts); Step named = {.name = "n", .shifts = 4}; scamp5_in(B, named.name[0] + named.shifts);
Tag t; scamp5_in(C, t.text[1]); scamp5_in(C, t.n); char rows[2][3][4] = {{"a", "b"}, {"ccc"}}; scamp5_in(C, rows[0][1][0]); scamp5_in(C, rows[1][0][2]); scamp5_in(C, rows[1][2][0]); for (std::string it : names) scamp5_in(C, (int)it.size()); unsigned char u[4] = {"A"}; scamp5_in(C, u[0] + u[1]);"#,
        &[
            24, 68, 0, 3, 3, 0, 3, 99, 0, 8, 2, 3, 5, 105, 2, 4, 111, 0, 103, 7, 114, 100, 1, 98,
            99, 0, 2, 3, 1, 65,
        ],
    );
}

/// Through every door by which a value goes into a `std::string`: declarations, braces, assignments,
/// parameters, what functions give back, members, elements.
#[test]
fn texts_are_copies_of_what_they_are_given() {
    numbers(
        r#"char buf[8] = "k"; const std::string mode{"edge"}; struct S { std::string n{"m"}; int v; }; struct P { std::string n; int v = 2; P(const std::string& it) : n(it) {} P(const char* it, int k) : n{it}, v(k) {} void name(const char* it) { n = it; } };
bool is(const std::string& s) { return s == "k"; } bool by(std::string s) { s += 'x'; return s == "kx"; } std::string name(int n) { char b[8]; sprintf(b, "f%d", n); return b; } std::vector<std::string> both() { char b[4] = "q"; return {b, "r"}; } struct Q { std::string n; int v; }; Q made() { char b[4] = "z"; return {b, 3}; }"#,
        r#"scamp5_in(A, mode == "edge"); std::string a = {"edge"}, e{}, c{'a', 'b'}, d{buf}; scamp5_in(A, a == mode); scamp5_in(A, e == "" && e.empty()); scamp5_in(A, c == "ab"); scamp5_in(A, d == "k"); scamp5_in(A, is({"k"})); S s; scamp5_in(A, s.n == "m"); S t{buf, 5}; scamp5_in(A, t.n == "k" && t.v == 5);
std::string u; u = buf; std::vector<std::string> v; v.push_back(buf); v.emplace_back(buf); v.emplace_back("abc", 2); v.emplace_back(2, 'z'); std::map<int, std::string> m; m[1] = buf; m.insert({2, buf}); m.emplace(3, buf); P p(buf); P q(buf, 9); Q r = {buf, 1}; std::pair<int, std::string> pair(1, buf); std::string all[2] = {buf}; p.name(buf); auto w = std::string(buf);
buf[0] = 'w'; scamp5_in(B, u == "k"); scamp5_in(B, v[0] == "k"); scamp5_in(B, v[1] == "k"); scamp5_in(B, v[2] == "ab" && v[3] == "zz"); scamp5_in(B, m[1] == "k"); scamp5_in(B, m[2] == "k" && m[3] == "k"); scamp5_in(B, p.n == "k"); scamp5_in(B, q.n == "k" && q.v == 9); scamp5_in(B, r.n == "k"); scamp5_in(B, pair.second == "k"); scamp5_in(B, all[0] == "k" && all[1] == ""); scamp5_in(B, w == "k"); w += 'c'; scamp5_in(B, w == "kc");
scamp5_in(C, is(buf)); buf[0] = 'k'; scamp5_in(C, is(buf)); scamp5_in(C, by(buf)); scamp5_in(C, name(3) == "f3"); u = name(4); scamp5_in(C, u == "f4"); auto f = name(5); f += 'x'; scamp5_in(C, f == "f5x"); scamp5_in(C, both()[0] == "q" && both()[1] == "r"); scamp5_in(C, made().n == "z"); r = {buf, 8}; buf[0] = 'y'; scamp5_in(C, r.n == "k"); v = {buf, "b"}; buf[0] = 'k'; scamp5_in(C, v[0] == "y"); v[1] = buf; scamp5_in(C, v[1] == "k"); for (std::string it : v) { it += '!'; scamp5_in(C, it.size()); } for (auto it : v) { it += '!'; scamp5_in(C, it == "y!" || it == "k!"); }
const char* lead = "ab"; scamp5_in(D, is(lead)); auto add = [](const std::string& it) { return it + 'c'; }; scamp5_in(D, add(lead) == "abc"); scamp5_in(D, add(buf) == "kc");"#,
        &[
            1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 0, 1, 1, 1, 1, 1, 1, 1,
            1, 1, 1, 2, 2, 1, 1, 0, 1, 1,
        ],
    );
}

/// By what they hold, from either side; arrays of the library have an order too.
#[test]
fn texts_are_compared_with_arrays_of_characters() {
    numbers(
        "char buf[8];",
        r#"sprintf(buf, "m%d", 2); std::string want = "m2"; scamp5_in(A, want == buf); scamp5_in(A, buf == want); scamp5_in(A, want != buf); scamp5_in(A, std::string(buf) == "m2"); scamp5_in(A, want + buf == "m2m2"); want += buf; scamp5_in(A, want == "m2m2"); scamp5_in(A, std::string("a") + buf == "am2"); scamp5_in(A, buf + std::string("!") == "m2!");
std::string a = "a", b = "b"; scamp5_in(B, a < b); scamp5_in(B, a > b); scamp5_in(B, a <= "a"); scamp5_in(B, "b" >= a); scamp5_in(B, want < buf); std::array<int, 2> x = {1, 2}, y = {1, 3}; scamp5_in(B, x < y); scamp5_in(B, x >= y); std::vector<int> v = {1}, w = {1, 0}; scamp5_in(B, v < w); scamp5_in(B, v == w); const char* p = buf; scamp5_in(B, p == buf); scamp5_in(B, p == NULL);"#,
        &[1, 1, 0, 1, 1, 1, 1, 1, 1, 0, 1, 1, 0, 1, 0, 1, 0, 1, 0],
    );
}

/// Constructors of two and three arguments; what `append` gives back is the text itself.
#[test]
fn texts_are_made_of_parts() {
    numbers(
        "",
        r#"std::string a("abc", 2), b("abc"), c(b, 1, 1), d(2, 'k'), e(b, 1), f("abcd", 1, 2), g(b.begin(), b.end()); scamp5_in(A, a == "ab"); scamp5_in(A, c == "b"); scamp5_in(A, d == "kk"); scamp5_in(A, e == "bc"); scamp5_in(A, f == "bc"); scamp5_in(A, g == "abc"); scamp5_in(A, std::string("abc", 1) == "a"); scamp5_in(A, std::string{"q"} + 'r' == "qr"); std::vector<std::string> v = {std::string{b}, std::string(3, 'x')}; scamp5_in(A, v[0] == "abc" && v[1] == "xxx");
std::string s; s.append("x").append("y"); scamp5_in(B, s == "xy"); (s += "a") += "b"; scamp5_in(B, s == "xyab"); std::string& r = s.append("!"); r += "z"; scamp5_in(B, s == "xyab!z"); std::string t; t = s.append("?"); scamp5_in(B, t == s); t.append(2, '-'); scamp5_in(B, t == "xyab!z?--"); struct { std::string n; } o; o.n.append("p").append("q"); scamp5_in(B, o.n == "pq"); scamp5_in(B, b + t.back() == "abc-");"#,
        &[1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1, 1],
    );
}

/// Functions, characters and algorithms over all of a text.
#[test]
fn texts_are_changed_in_place() {
    numbers(
        "",
        r#"std::string s = "abc"; s[1] = 'X'; scamp5_in(A, s == "aXc"); s[0] += 1; scamp5_in(A, s == "bXc"); scamp5_in(A, s.front()); scamp5_in(A, s.back()); scamp5_in(A, s.at(1)); s.pop_back(); s.insert(1, "--"); scamp5_in(A, s == "b--X"); s.erase(0, 1); s.erase(2); scamp5_in(A, s == "--"); s.replace(1, 1, "ZZ"); scamp5_in(A, s == "-ZZ"); s.resize(2); scamp5_in(A, s == "-Z"); s.resize(4, 'q'); scamp5_in(A, s == "-Zqq"); scamp5_in(A, (int)s.rfind("q")); scamp5_in(A, s.find('q', 3) == 3); scamp5_in(A, s.find("z") == std::string::npos); scamp5_in(A, s.compare("-A") > 0); scamp5_in(A, s.compare(s)); s.insert(s.begin(), '<'); s.insert(s.end(), 2, '>'); scamp5_in(A, s == "<-Zqq>>"); s.erase(s.begin() + 1); scamp5_in(A, s == "<Zqq>>"); s.assign("new"); scamp5_in(A, s == "new"); scamp5_in(A, (int)s.find_first_of("xw"));
std::string t = "hello"; std::reverse(t.begin(), t.end()); scamp5_in(B, t == "olleh"); std::sort(t.begin(), t.end()); scamp5_in(B, t == "ehllo"); scamp5_in(B, std::count(t.begin(), t.end(), 'l')); scamp5_in(B, std::find(t.begin(), t.end(), 'o') - t.begin()); scamp5_in(B, std::find(t.begin(), t.end(), 'x') == t.end()); std::transform(t.begin(), t.end(), t.begin(), [](char c) { return c - 32; }); scamp5_in(B, t == "EHLLO"); t.erase(std::remove(t.begin(), t.end(), 'L'), t.end()); scamp5_in(B, t == "EHO"); scamp5_in(B, std::count_if(t.begin(), t.end(), [](char c) { return c > 'F'; })); int sum = 0; for (auto it = t.begin(); it != t.end(); ++it) sum += *it; scamp5_in(B, sum - 128);
std::string a = "x-y-", b = "z"; for (auto it = a.begin(); it != a.end();) { if (*it == '-') it = a.erase(it); else ++it; } scamp5_in(C, a == "xy"); auto at = a.insert(a.begin() + 1, '+'); scamp5_in(C, *at); scamp5_in(C, a == "x+y"); a.swap(b); scamp5_in(C, a == "z" && b == "x+y"); auto more = [a](char c) { return a + c; }; scamp5_in(C, more('!') == "z!"); auto p = std::make_pair(std::string("k"), 2); scamp5_in(C, p.first + 'l' == "kl"); std::map<int, std::string> m; m[1] = "q"; m[1] += 'r'; scamp5_in(C, m[1] + 's' == "qrs"); std::vector<std::string> v = {"a"}, w(v.begin(), v.end()); w.insert(w.end(), v.begin(), v.end()); scamp5_in(C, w[1] == "a" && w[0] + 'b' == "ab"); scamp5_in(C, (a.empty() ? b : a) + '.' == "z.");
char key[4] = "k", rows[2][4] = {"r", "st"}; std::map<std::string, int> keys = {{key, 2}}; keys[key]++; keys.insert({key, 9}); key[0] = 'z'; scamp5_in(D, keys["k"]); scamp5_in(D, (int)keys.size()); std::vector<std::string> names(rows, rows + 2); rows[1][0] = 'x'; scamp5_in(D, names[1] == "st"); scamp5_in(D, std::find(names.begin(), names.end(), "st") - names.begin()); std::vector<char> codes = {'u', 'v'}; scamp5_in(D, std::string(codes.begin(), codes.end()) == "uv");"#,
        &[
            1, 1, 98, 99, 88, 1, 1, 1, 1, 1, 3, 1, 1, 1, 0, 1, 1, 1, 2, 1, 1, 2, 4, 1, 1, 1, 2, 92,
            1, 43, 1, 1, 1, 1, 1, 1, 1, 3, 1, 1, 1, 1,
        ],
    );
}

/// In lengths, in what members begin with, and behind the class; labels belong to a statement.
#[test]
fn classes_know_their_own_constants_and_types() {
    numbers(
        r"const int N = 9; class Tracker { public: static const int MAX = 4; uint8_t xy[MAX * 2]; int n = MAX + 1; }; struct F { enum class Mode : uint8_t { Off, On }; Mode m = Mode::On; enum { K = 4 }; int a[K]; std::array<int, K> b; static const int M = K * 2; int c[M]; static const int T[K]; int get(int k = M) { return k; } };
const int F::T[K] = {1, 2, 3, M}; namespace cfg { struct G { static constexpr int N = 3; int a[N]; int b[N + 1][2]; int d = N; }; } enum class Dir : uint8_t { North, East }; enum Wide : uint16_t { LOW };
struct Own { typedef uint8_t T; T v; using U = float; U w = 3; using L = std::vector<int>; L all; T half() { T x = v / 2 + 255; return x; } T twice(T x); }; Own::T Own::twice(T x) { T y = x + x; return y; } typedef float T;",
        r"Tracker t; t.xy[7] = 3; scamp5_in(A, sizeof(t.xy)); scamp5_in(A, t.n); F f; scamp5_in(A, f.m == F::Mode::On); scamp5_in(A, sizeof(f.a) / 4); f.b[3] = 7; scamp5_in(A, f.b[3]); scamp5_in(A, sizeof(f.c) / 4); scamp5_in(A, F::M); scamp5_in(A, F::T[3]); scamp5_in(A, f.get()); cfg::G g; scamp5_in(A, sizeof(g.a) / 4); g.b[3][1] = 1; scamp5_in(A, sizeof(g.b) / 4); scamp5_in(A, g.d); scamp5_in(A, N);
scamp5_in(B, sizeof(Dir)); scamp5_in(B, sizeof(Wide)); scamp5_in(B, sizeof(F::Mode)); Dir path[6]; scamp5_in(B, sizeof(path)); Own o; o.v = 300; scamp5_in(B, o.v); scamp5_in(B, (int)(o.w / 2 * 10)); o.all.push_back(4); scamp5_in(B, o.all[0]); scamp5_in(B, o.half()); scamp5_in(B, o.twice(130)); Own::T x = 257; scamp5_in(B, x); T y = 1.5f; scamp5_in(B, (int)(y * 2));
int i = 0; while (i < 10) { if (i > 5) out: break; i++; } scamp5_in(C, i); if (i == 6) a: b: i = 8; scamp5_in(C, i); end: ; scamp5_in(C, 1);",
        &[
            8, 5, 1, 4, 7, 8, 8, 8, 8, 3, 8, 3, 9, 1, 2, 1, 6, 44, 15, 4, 21, 4, 1, 3, 6, 8, 1,
        ],
    );
}

/// What is not supported of a text is told, and does not fit is.
#[test]
fn what_texts_do_not_take_is_refused() {
    for (inside, message, help) in [
        (
            "int k = 1;\nunsigned char u[] = \"\\xff\\x80\"; scamp5_in(A, u[0] - 200);",
            "a string with a 0 inside, or with bytes that are not UTF-8",
            "{0xff, 0x80}",
        ),
        (
            "int k = 1;\nscamp5_in(A, strlen(\"a\\0b\"));",
            "a string with a 0 inside, or with bytes that are not UTF-8",
            "an array of numbers",
        ),
        (
            "int k = 1;\nchar a[3] = \"abc\"; scamp5_in(A, a[0]);",
            "4 characters with the terminating 0, but there is room for 3",
            "no more values",
        ),
        (
            "std::string s = \"ab\";\ns.swap_ranges(1); scamp5_in(A, 1);",
            "`s.swap_ranges` of the string \"ab\" is not supported",
            "`substr`",
        ),
        (
            "std::string s = \"ab\";\nscamp5_in(A, s.substr(5) == \"\");",
            "`s.substr` of the string \"ab\" is not supported",
            "within its length",
        ),
        (
            "std::string s = \"ab\";\ns[7] = 'c'; scamp5_in(A, 1);",
            "index out of range in the string \"ab\"",
            "the length minus one",
        ),
        (
            "std::string s = \"ab\";\nstd::sort(s.begin() + 1, s.end()); scamp5_in(A, s == \"ab\");",
            "`sort` over part of a string is not supported",
            "a whole string",
        ),
        (
            "std::string s = \"ab\"; auto i = s.begin();\nstd::reverse(i, s.end()); auto j = s.end(); std::reverse(i, j); scamp5_in(A, 1);",
            "`reverse` over part of a string is not supported",
            "a whole string",
        ),
    ] {
        told(&format!("int main() {{ {inside} }}"), 2, message, help);
    }
    // What is not known is not taken for unlike.
    told(
        "char b[4]; int main() { b[0] = scamp5_global_or(R5); std::string s = \"a\";\nif (s == b) { mov(A, B); } }",
        2,
        "whether this kernel runs depends on the characters in `b`",
        "",
    );
}

/// What is not supported is told by its name.
#[test]
fn ends_that_are_seen_and_decltype_are_refused() {
    told(
        "struct G { int id;\n~G() { vs_post_text(\"%d\\n\", id); } };\nint main() { G g{1}; scamp5_in(A, 1); }",
        2,
        "the destructor of `G` shows or posts something",
        "at the end of the object's lifetime",
    );
    told(
        "int main() { int x = 1;\nconst decltype(x) y = 2; scamp5_in(A, y); }",
        2,
        "`decltype` is not supported",
        "`auto`",
    );
    // A template of any number of types is told where it is called, and nowhere else.
    let any = "template <typename... T> void log(T... all) { }\ntemplate <typename... T> int count(const T&... all) { return sizeof...(all); }\n";
    told(
        &format!("{any}int main() {{ scamp5_in(A, count(1, 2)); }}"),
        3,
        "`count` is a variadic template, which is not supported",
        "write a function for each number of arguments",
    );
    numbers(any, "scamp5_in(A, 4);", &[4]);
    told(
        "int main() {\ntry { scamp5_in(A, 1); } catch (...) { }\nnop(); }",
        2,
        "`try` is not supported",
        "without `try`",
    );
    told(
        "int main() {\nthrow 3;\nnop(); }",
        2,
        "`throw` is not supported",
        "leave it out",
    );
    told(
        "struct B { unsigned a : 3; unsigned b : 5; };\nint main() { B b; b.a = 2; scamp5_in(A, b.a); }",
        2,
        "depends on `b`, a class with bit fields in line 1, which is not supported",
        "docs/vendor-code.md",
    );
    numbers(
        "enum class Mode { OFF, LOW = 5 }; using M = Mode;",
        "Mode m = M::LOW; scamp5_in(A, m == Mode::LOW);",
        &[1],
    );
}

/// With data of its own, declared at once or by its name; an enumeration has the size of its type.
#[test]
fn classes_inside_of_classes() {
    numbers(
        "struct T { struct In { int k = 3; int twice() const { return 2 * k; } }; In in; int n = 1; struct { int x; int y; } at = {4, 5}; struct Q { uint8_t b = 250; } q; }; enum Flags : uint8_t { NONE, ONE }; enum Plain { P }; template <typename T, typename U> auto sum(T a, U b) -> decltype(a + b) { return a + b; }",
        "T t; scamp5_in(A, t.in.twice()); scamp5_in(A, t.n); scamp5_in(A, t.at.y); t.q.b += 10; scamp5_in(A, t.q.b); T::In z; z.k = 8; t.in = z; scamp5_in(A, t.in.k); std::vector<T> all(2); all[1].in.k = 6; scamp5_in(A, all[0].in.k + all[1].in.k);
Flags f = ONE; Plain p = P; scamp5_in(B, sizeof(f)); scamp5_in(B, sizeof(p)); scamp5_in(B, (int)(2 * sum(1, 2.5)));",
        &[6, 1, 5, 4, 8, 9, 1, 4, 7],
    );
}

/// Once for each place, not for each value.
#[test]
fn what_is_cut_off_is_told_once() {
    let text =
        "int main() { for (int i = 0; i < 3; i++) scamp5_in(A, i + 0.5);\nscamp5_in(B, 1.5); }";
    let all = expand(text).unwrap().warnings;
    let cut = all
        .iter()
        .filter(|it| it.message.contains("passes the integer"));
    assert_eq!(cut.count(), 2, "{all:#?}");
}
