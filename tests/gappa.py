"""Proves the error bounds of pbw.h with Gappa: gappa.py HEADER SCRIPTS [first].  HEADER: pbw.h, pbw_query.h and
pbw_live.h in one file.  Keeps Gappa's input in SCRIPTS; with
`first` it ends at the first bound that is not proved.

The operations are read from the header: each predicate's expressions are evaluated on values that record the
operations.  A different order of operations, or a different constant, gives a different proof.

Let a value x be computed for an exact value X, a sum of products, and let P be the sum of the absolute products, its
permanent.  Then |X| <= P, and Gappa proves |x - X| <= k P for the result of each operation from those of its operands.
Operands are scaled by their permanents, so every lemma has P = 1.  In a sum, errors and permanents add up: the larger
k holds for both terms.  Gappa's relative rounding has no smallest exponent; the loss to underflow is added at the end.
There Gappa proves that the error is below the bound, rounding errors of the bound included, and must fail to prove it
for a tenth of the bound.

A pair has |tail| <= K P and |head + tail - X| <= E P.  Two theorems are taken from the literature: the error of a sum
(Knuth 1969) and of a product (Dekker 1971) of doubles is itself a double."""
import copy
import math
import re
import subprocess
import sys
from fractions import Fraction

HEADER = open(sys.argv[1]).read()
TEXT = re.sub(r'/\*.*?\*/', '', HEADER, flags=re.S)
SCRIPTS = open(sys.argv[2], 'w')
U = Fraction(1, 2 ** 53)
passed, failed = [], []
lemmas, proved = {}, {}                                  # not proved yet; proved, with what Gappa said


# ---- reading the header
def read(name):
    """The parameters of a function and its statements."""
    found = re.search(r'\b%s\(((?:[^()]|\([^()]*\))*)\)\s*\n\{\n(.*?)\n\}' % name, TEXT, re.S)
    if not found:
        raise SystemExit('%s is not in the header' % name)
    text = ' '.join(found.group(2).replace('->', '.').replace('&&', 'and').split())
    choice = r'(?:[^?:(),;=]|[=<>]=|\([^()]*\))+?'
    text = re.sub(r'(%s) \? (%s) : (%s)(?=[,;)])' % (choice, choice, choice), r' (\2 if \1 else \3)', text)
    text = re.sub(r'\(([^;]*?) if +return ', r'return (\1 if ', text)
    names = [re.search(r'(\w+)\W*(?:\[\d*\])?$', p.replace(')', '')).group(1) for p in found.group(1).split(',')]
    return names, re.split(r'([;{}])', text)


def split(text):
    """At commas outside of parentheses."""
    parts, depth = [''], 0
    for c in text:
        depth += (c in '([') - (c in ')]')
        if c == ',' and depth == 0:
            parts.append('')
        else:
            parts[-1] += c
    return parts


def unrolled(pieces, local):
    """Loops over k with a known end are written out; there are no braces in them."""
    return re.split(r'([;{}])', re.sub(
        r'for \(k = 0; k < (\w+); k\+\+\) \{([^{}]*)\}',
        lambda loop: ''.join('k = %d;' % k + loop.group(2) for k in range(eval(loop.group(1), local))),
        ''.join(pieces)))


def run(name, local, wanted):
    """Does the assignments to `wanted` in a function, in their order; returns what it returns, if that is wanted.
    A condition that is known here is obeyed; loops are passed through once, but see unrolled, if k is wanted."""
    local, depth, skip, missing = dict(ENV, **local), 0, None, set(wanted)
    held = None                                          # the depth of a condition that held, until its end
    for piece in unrolled(read(name)[1], local) if 'k' in wanted else read(name)[1]:
        piece = piece.strip()
        depth += (piece == '{') - (piece == '}')
        if skip is not None and not (piece == '}' and depth == skip):
            continue
        skip = depth if piece == 'else' and held == depth else None
        if skip is not None:
            continue
        known = re.match(r'if \(([\w.]+ == \w+)\)$', piece)
        if known and not eval(known.group(1), local):
            skip = depth
            continue
        held = depth if known else held
        for part in split(piece):
            part = re.sub(r'^\s*(?:const |double |int |pbw\w+ )*\*?', '', part)
            target = re.match(r'return|[\w.\[\]]+(?= *[-+*]?= )', part)
            if target and target.group() in wanted:
                missing.discard(target.group())
                if target.group() == 'return':
                    return eval(part[6:].strip() or 'None', local), local
                exec(part, local)
    if missing:
        raise SystemExit('%s: no %s' % (name, ' '.join(sorted(missing))))
    return None, local


def define(*names):
    """Functions of the header, which return an expression, as functions of Python."""
    for name in names:
        ENV[name] = lambda *given, name=name: run(name, dict(zip(read(name)[0], given)), ['return'])[0]


def constant(name):
    return float(re.search(r'#define %s +([-\d.e]+)' % name, TEXT).group(1))


def literal(name, pattern):
    return Fraction(float(re.search(pattern, ' '.join(read(name)[1])).group(1)))


# ---- numbers for Gappa: 40 bits
def rounded(x, to):
    if x == 0:
        return Fraction(0)
    unit = Fraction(2) ** (math.frexp(x)[1] - 40)
    return to(x / unit) * unit


def up(x):
    return rounded(Fraction(x), math.ceil)


def g(x):
    x = Fraction(x)
    return '%db-%d' % (x.numerator, x.denominator.bit_length() - 1)


# ---- values
class Value:
    bits = 53                                            # 52 in any rounding mode, where a rounding errs by 2^-52
    count = 0                                            # of operations that may underflow
    pair = None                                          # the pair that this is the head of

    def __init__(self, k=0, P=1):
        self.k, self.P = up(k), Fraction(P)

    def rounded(self):
        """An exact sum or product is rounded."""
        Value.count += 1
        u = Fraction(1, 2 ** Value.bits)
        k = up(self.k + u * (1 + self.k))
        lemmas['r = add_rel<%d>(a, b);\n{ |a + b - X| <= %s /\\ |X| <= 1 -> |r - X| <= %s }\n'
               'r - X -> (r - (a + b)) + (a + b - X);\na + b -> (a + b - X) + X;\n'
               % (Value.bits, g(self.k), g(k))] = 0
        return Value(k, self.P)

    def times(self, b):                                  # not rounded
        b = value(b)
        k = up(self.k + b.k + self.k * b.k)
        lemmas['{ |a - A| <= %s /\\ |A| <= 1 /\\ |b - B| <= %s /\\ |B| <= 1 -> |a * b - A * B| <= %s }\n'
               'a * b - A * B -> (a - A) * B + A * (b - B) + (a - A) * (b - B);\n' % (g(self.k), g(b.k), g(k))] = 0
        return Value(k, self.P * b.P)

    def plus(self, b):
        b = value(b)
        return Value(max(self.k, b.k), self.P + b.P)

    def __mul__(self, b):
        return self.times(b).rounded()

    def __add__(self, b):
        exact = self.pair is not None or not isinstance(b, Value) and b == 0
        return self if exact else self.plus(b).rounded()

    def __rsub__(self, b):
        return self.plus(b).rounded()

    def __neg__(self):
        return self

    def __lt__(self, b):
        return True

    def __gt__(self, b):
        return True

    __rmul__, __radd__, __sub__ = __mul__, __add__, __add__


def value(x):
    return x if isinstance(x, Value) else Value(0, abs(Fraction(x)))


class Number:                                            # a coordinate or weight of the input
    def __init__(self, P):
        self.P = P

    def __sub__(self, b):
        return Value(0, self.P).rounded()

    def __add__(self, places):                           # to the right in an array
        return self


class Every:                                             # an array with the same value everywhere
    def __init__(self, x):
        self.x = x

    def __getitem__(self, i):
        return self.x

    def __setitem__(self, i, x):
        self.x = x


class Rows:                                              # relative to the point, in lanes
    ghost = y = x = z = weight = lift = height = None


class Pair:
    tail = 0

    def __init__(self, K, E, P=1):
        self.K, self.E, self.P = up(K), up(E), Fraction(P)

    @property
    def head(self):
        head = Value(self.K + self.E, self.P)
        head.pair = self
        return head

    @head.setter
    def head(self, x):
        pass


def pair_plus(a, b):
    Value.count += 1
    K0, E0 = max(a.K, b.K), max(a.E, b.E)
    K = up((U * (1 + K0 + E0) + K0 * (1 + U)) * (1 + U))
    E = up(E0 + U * K0 + U * (U * (1 + K0 + E0) + K0 * (1 + U)))
    lemmas['s = p + q;\nh = add_rel<53>(p, q);\ne = s - h;\nt0 = add_rel<53>(v, w);\nt = add_rel<53>(e, t0);\n'
           '{ |s + (v + w) - X| <= %s /\\ |v + w| <= %s /\\ |X| <= 1 -> |t| <= %s /\\ |h + t - X| <= %s }\n'
           's -> (s + (v + w) - X) + X - (v + w);\nt0 -> (t0 - (v + w)) + (v + w);\n'
           'h + t - X -> (t - (e + t0)) + (t0 - (v + w)) + (s + (v + w) - X);\n' % (g(E0), g(K0), g(K), g(E))] = 0
    return Pair(K, E, a.P + b.P)


def pair_times(a, b):
    Value.count += 1
    ha, hb = 1 + a.K + a.E, 1 + b.K + b.E
    cross = ha * b.K + a.K * hb
    tail = U * ha * hb + cross * (1 + U) ** 2
    K = up(tail * (1 + U))
    E = up(U * tail + cross * (2 * U + U * U) + a.K * b.K + a.E * (1 + b.E) + b.E * (1 + a.E) + a.E * b.E)
    for fused in (0, 1):
        lemmas['h = mul_rel<53>(p, q);\ne = p * q - h;\n%s'
               '{ |p + v - X| <= %s /\\ |v| <= %s /\\ |X| <= 1 /\\ |q + w - Y| <= %s /\\ |w| <= %s /\\ |Y| <= 1 ->\n'
               '  |t| <= %s /\\ |h + t - X * Y| <= %s }\n'
               'p -> (p + v - X) + X - v;\nq -> (q + w - Y) + Y - w;\n'
               'h + t - X * Y -> (t - (e + (p * w + v * q))) - v * w + ((p + v - X) * Y + X * (q + w - Y)\n'
               '  + (p + v - X) * (q + w - Y));\n%s'
               % ('t0 = fma_rel<53>(v, q, e);\nt = fma_rel<53>(p, w, t0);\n' if fused else
                  't1 = mul_rel<53>(p, w);\nt2 = mul_rel<53>(v, q);\n'
                  't0 = add_rel<53>(t1, t2);\nt = add_rel<53>(e, t0);\n',
                  g(a.E), g(a.K), g(b.E), g(b.K), g(K), g(E),
                  't - (e + (p * w + v * q)) -> (t - (p * w + t0)) + (t0 - (v * q + e));\n' if fused else
                  't - (e + (p * w + v * q)) -> (t - (e + t0)) + (t0 - (t1 + t2)) + (t1 - p * w) + (t2 - v * q);\n')
               ] = 0
    return Pair(K, E, a.P * b.P)


# ---- proofs
def gappa(text):
    SCRIPTS.write(text + '\n')
    answer = subprocess.run(['gappa'], input=text, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                            universal_newlines=True)
    return answer.stdout or 'no proof' if answer.returncode else ''


def report(name, problem):
    (failed if problem else passed).append(name)
    if problem:
        print('FAILED %s: %s' % (name, problem.strip()))
        if len(sys.argv) > 3:
            raise SystemExit(1)


def judge(name, answer, tenth):
    report(name + tenth, answer if not tenth else '' if answer else 'is proved as well')


def prove(name, det, bound, least=None, square=False):
    """The sign of det is certain where |det|, or det * det, is above bound.  least: at most the product of the scales
    that det is divided by here.  An operation loses at most 2^-1020 to underflow, times its cofactor."""
    problem = ''
    for text in lemmas:
        if text not in proved:
            proved[text] = gappa(text)
            problem = problem or proved[text] and text + proved[text]
    lemmas.clear()
    det = det.pair if isinstance(det, Value) and det.pair is not None else det
    error = det.E if isinstance(det, Pair) else det.k
    lost = Value.count * 64 * Fraction(2) ** -1020 / Fraction(least) if least else Fraction(0)
    low = rounded(bound.P * (1 - bound.k) - (2 ** -1020 / Fraction(least) ** 2 if square else 0), math.floor)
    compared = 'mul_rel<53>(error, error)' if square else 'add_rel<53>(error, 0)'
    last = ('error = r * P + lost;\n{ |r| <= %s /\\ |P| <= %s /\\ |lost| <= %s -> |%s| <= %%s }\n'
            % (g(error), g(up(det.P)), g(up(lost)), compared))
    answer = gappa('# %s\n' % name + last % g(low))
    tenth = gappa('# must fail\n' + last % g(up(low / (100 if square else 10))))
    part = float(error * det.P) / (float(bound.P) ** 0.5 if square else float(bound.P))
    print('passed %-28s error at most %.4f of the bound' % (name, part))
    judge(name, problem or answer, '')
    judge(name, tenth, ', a tenth of the bound')


# ---- the functions of the header
class Three:                                             # three lanes and a zero
    def __init__(self, x):
        self.sum = (x + x) + x


def same(*x):                                            # of values of one scale, the largest
    return next((y for y in x if isinstance(y, Value)), x[0])


def fma(a, b, c):
    return value(a).times(b).plus(c).rounded()


ENV = {'DBL_EPSILON': 2.0 ** -52, 'pbw__splat': same, 'pbw__max_lane': same, 'pbw__fma': fma, 'pbw__fnma': fma,
       'pbw__det2': lambda a, b, c, d: value(b * c).plus(value(a).times(d)).rounded(),
       'pbw__and4': lambda mask, x: x, 'pbw__andnot4': lambda mask, x: x,
       'pbw__sum_lanes': lambda x: x.sum if isinstance(x, Three) else (x + x) + (x + x),
       'pbw__drop_last': lambda x: Three(x), 'pbw__certain': lambda det, bound, low, high: (det, bound),
       'pbw__pair_difference': lambda a, b: Pair(U * (1 + U), 0, a.P), 'pbw__pair_plus': pair_plus,
       'pbw__pair_minus': pair_plus, 'pbw__pair_times': pair_times, 'pbw__plus4': pair_plus, 'pbw__minus4': pair_plus,
       'pbw__times4': pair_times, 'pbw__first': same, 'pbw__load4d': same, 'HUGE_VAL': 0}
for name in 'max', 'abs', 'max_abs', 'max4', 'abs4':
    ENV['pbw__' + name] = same
ENV['pbwl__sqrt4'] = lambda x: Value(x.k + U, 1)          # of a value of scale 1; its root errs by less
ENV['PBW__CORNER_A'] = ENV['PBW__CORNER_B'] = ENV['PBW__CORNER_C'] = same
for name in re.findall(r'#define (PBWL?__\w+_ERROR)', TEXT) + ['PBW__EPSILON']:
    ENV[name] = constant(name)
ENV['PBW__GHOST'] = 0


def scaled(*lifts):
    """|x|^2 and |weight| add up to the height of a row, which is 1 here."""
    for lift in lifts:
        lift.P = Fraction(1)


def vectors(dim, weighted=True):
    rows, p = Rows(), Rows()
    p.x = p.y = p.z = Number(1)
    p.weight = Number(0)
    p.dim, p.weighted = dim, weighted
    names = ['rows.x', 'rows.y', 'rows.z', 'rows.lift'] + ['weight', 'rows.height'] * weighted
    local = dict(rows=rows, p=p, dim=dim, x=p.x, y=p.y, z=p.z, w=p.weight)
    run('pbw__rows4_of', local, names)
    scaled(rows.lift, rows.height)
    return rows


def scalars(dim):
    row = [None] * 4
    names = ['row[%d]' % k for k in range(dim)] + ['row[dim]', 'weight', 'square']
    record, kernel = [Number(1)] * dim + [Number(0)], Rows()
    kernel.weighted = True
    local = run('pbw__row', dict(kernel=kernel, row=row, record=record, p=record, v=1, dim=dim), names)[1]
    height = run('pbw__row', local, ['return'])[0]
    scaled(row[dim], height)
    return row, height


def filters():
    """In any rounding mode, with and without flush-to-zero."""
    Value.bits = 52
    low = literal('pbw__certain', r'low > ([-\d.e]+)')
    for power in (0, 1):
        for dim in (2, 3):
            name = 'pbw__filter_%s%d' % (('orient', 'power')[power], dim)
            record = [Number(1)] * dim + [Number(0)]
            local = dict.fromkeys('abcdp', record)
            rows = range(dim + power)
            axes = 'xyz'[:dim]
            local = run(name, local, [c + str(i) for i in rows for c in axes + 'wl' * power])[1]
            if power:
                scaled(*[local['l%d' % i] for i in rows])
            names = ['m' + c for c in axes + 'l' * power] + ['det', 'return']
            if power and dim == 3:
                names += ['s01', 's02', 's03', 's12', 's13', 's23']
            (det, bound), local = run(name, dict(local, low=0, high=0), names)
            prove(name, det, bound, low ** (dim + 2 * power))
    Value.bits = 53


def pairs():
    low = literal('pbw__certain', r'low > ([-\d.e]+)')
    define('pbw__pair_cross', 'pbw__pair_minor', 'pbw__pair_sum')
    ENV['pbw__pair_scaled'] = lambda pair, scale: pair   # by a power of two
    for power in (0, 1):
        for dim in (2, 3):
            u, v, lift = Every(None), Every(None), Every(None)
            local = dict(dim=dim, count=dim + power, i=0, k=0, u=Every(u), v=Every(v), lift=lift, low=0, high=0,
                         scale=1, row=Every(Every(Number(1))), origin=Every(Number(1)))
            local = run('pbw__pairs', local, ['v[k][i]', 'largest', 'u[k][i]'])[1]
            local['size'] = ENV['PBW__EPSILON'] ** 2
            for k in range(dim):
                local['size'] = local['size'] * local['largest']
            if power:
                local['origin'] = Every(Number(0))
                local = run('pbw__pairs', local, ['lift[i]', 'weight', 'high'])[1]
                scaled(lift[0], local['high'])
                local['size'] = local['size'] * local['high']
            det, bound = run('pbw__pairs', local, ['det', 'return'])[0]
            prove('pbw__pairs %s%d' % (('orient', 'power')[power], dim), det, bound, low ** (dim + 2 * power))


def root(x):
    return Fraction(math.isqrt(int(x * 10 ** 200))) / 10 ** 100


def walks():
    define('pbw__det3')
    name = 'pbw__locate_of'
    least = literal(name, r'height = ([-\d.e]+)')
    for dim in (2, 3):
        row, h = scalars(dim)
        local = dict(u=Every(row), corner=Every(0), a=row, b=row, i=0, dim=dim, height=h, lowest=0, exit=0,
                     corners=1)
        local = run(name, local, ['square', 'bound', 'limit', 'side', 'power'])[1]
        scale = root(least) if dim == 3 else 1
        prove('%s%d side' % (name, dim), local['side'], local['bound'], least * scale, True)
        det = local['power'] + local['power']
        for i in range(dim - 1):
            det = det + local['power']
        prove('%s%d power' % (name, dim), det, local['limit'], least ** 2 * scale, True)
    r = vectors(3)
    name = 'pbw__locate3_simd'
    names = ['side', 'power', 'h', 'square', 'bound', 'limit']
    names += [a + c for a in 'abc' for c in 'xyz']
    local = run(name, dict(r=r, rounded=0), names)[1]
    prove(name + ' side', local['side'], local['bound'], least * root(least), True)
    prove(name + ' power', local['power'], local['limit'], least ** 2 * root(least), True)
    name = 'pbw__locate2_simd'
    define('pbw__circle_limit')
    least = literal(name, r'pbw__splat\((1e-[-\d.e]+)\)')
    r = vectors(2)
    local = run(name, dict(rows=r, sx=r.x, sy=r.y, ex=r.x, ey=r.y, h=r.height), ['side', 'power', 'bound'])[1]
    prove(name + ' side', local['side'], local['bound'], least)
    prove(name + ' power', local['power'], ENV['pbw__circle_limit'](r.height), least ** 2)


def cavities():
    row, h = scalars(3)
    name = 'pbw__carve3_scalar'
    least = literal(name, r', (1e-[-\d.e]+)\)')
    names = ['xy', 'xz', 'yz', 'xl', 'yl', 'zl', 'det', 'limit']
    local = run(name, dict(o=row, a=row, b=row, c=row, h=h), names)[1]
    prove(name, local['det'], local['limit'], least ** 2 * root(least), True)
    name = 'pbw__sphere4'
    r = vectors(3)
    names += [a + c for a in 'abc' for c in 'xyzl']
    det = run(name, dict(r=r, o=r), names + ['return'])[0]
    local = run('pbw__carve3_simd', dict(h=r.height, rounded=0), ['limit'])[1]
    prove(name, det, local['limit'], least ** 2 * root(least), True)

    name = 'pbw__power4_pairs'
    define('pbw__cross4', 'pbw__sum4')
    r = Rows()
    r.x = r.y = r.z = Pair(U * (1 + U), 0)
    run('pbw__pairs4_of', dict(rows=r, dim=3), ['rows.lift', 'rows.height'])
    scaled(r.lift, r.height)
    names = [n for n in names if n[0] in 'xyz' and len(n) == 2 and n[1] in 'xyzl']
    local = run(name, dict(o=r, a=r, b=r, c=r, h=r.height, height=r.height), names + ['det', 'limit'])[1]
    least = literal(name, r'pbw__splat\((1e-\d+)\)')
    prove(name, local['det'], local['limit'], least ** 2 * Fraction(1, 10 ** 10), True)

    name = 'pbw__test2'
    row, h = scalars(2)
    least = literal(name, r', (1e-\d+)\)')
    local = run(name, dict(a=row, b=row, c=row, height=h), ['det', 'limit'])[1]
    prove(name, local['det'], local['limit'], least ** 2)
    name = 'pbw__circle4'
    r = vectors(2)
    edges = Rows()
    edges.s = edges.e = edges.o = r
    det = run(name, dict(t=edges, height=None), ['det', 'return'])[0]
    prove(name, det, ENV['pbw__circle_limit'](r.height), least ** 2)
    bound = run('pbw__thin_limit', dict(t=edges, sx=r.x, sy=r.y, ex=r.x, ey=r.y, h=Value(0, 0)), ['sum', 'return'])[0]
    prove('pbw__thin_limit', det, bound)
    record = [Number(1)] * 2
    local = run('pbw__right_of', dict(a=record, b=record, p=record), ['ax', 'ay', 'bx', 'by'])[1]
    local['height'] = local['ax'] * local['ax'] + local['ay'] * local['ay']
    scaled(local['height'])
    prove('pbw__right_of', run('pbw__right_of', local, ['return'])[0],
          local['height'] * ENV['PBW__ORIENT2_ERROR'], least)

    name = 'pbw__circle4_pairs'
    r = Rows()
    r.x = r.y = Pair(U * (1 + U), 0)
    run('pbw__pairs4_of', dict(rows=r, dim=2), ['rows.lift'])
    scaled(r.lift)
    det = run(name, dict(o=r, s=r, e=r), ['det'])[1]['det']
    h = r.lift.head
    prove(name, det, h * h * ENV['PBW__CIRCLE_PAIRS_ERROR'], literal(name, r'pbw__splat\((1e-\d+)\)') ** 2)


def queries():
    """In any rounding mode, with and without flush-to-zero: pbw_locate_one leaves the caller's as it is."""
    Value.bits = 52
    for dim in (2, 3):
        name = 'pbwq__sides%d' % dim
        axes = 'xyz'[:dim]
        for i in range(dim + 1):
            names = ['m' + c for c in axes] + ['s01', 's02', 's03', 's12', 's13', 's23'] * (dim == 3)
            local = dict(side={}, **{c: Every(Number(1) - Number(1)) for c in axes})
            bound, local = run(name, local, names + ['low', 'high', 'side[%d]' % i, 'return'])
            prove('%s side %d' % (name, i), local['side'][i], bound, literal(name, r'low > ([-\d.e]+)') ** dim)
    squared = run('pbw__squared', dict(p=[Number(1)] * 3, q=[Number(1)] * 3, dim=3), ['x', 'y', 'z', 'return'])[0]
    squared.P = Fraction(1, 2)                           # so is that of the weight
    candidate, mesh = Rows(), Rows()
    mesh.weights = Every(Value(0, Fraction(1, 2)))
    q = run('pbwq__set_error', dict(fits=0, q=Every(None)), ['q[3]'])[1]['q']
    local = dict(squared=squared, q=q, candidate=candidate, mesh=mesh, vertex=0)
    run('pbwq__candidate_of', local, ['candidate.squared', 'candidate.slack'])
    prove('pbwq__candidate_of', candidate.squared, candidate.slack)
    name = 'pbwq__compare'
    local = run(name, dict(a=candidate, b=candidate), ['gap', 'slack'])[1]
    prove(name, local['gap'], local['slack'])
    name = 'pbwq__is_within'
    local = run(name, dict(a=candidate, radius=Value(0, 1)), ['squared', 'gap', 'slack'])[1]
    prove(name, local['gap'], local['slack'])
    # Beyond the limit d is at least t a.slack, t = 3 less the roundings of the product and of the sum: in units of a.slack
    # an eighth, as the sum is at most (1 + 2^-48) a.squared.  The slack of both is (2 a.slack + q[3] d) (1 + 8u).
    factor = literal('pbwq__square_limit', r'([\d.]+) \* a.slack')
    error = Fraction(constant('PBW__REACH_ERROR')) / 2 ** 52
    for tenth in '', ', a tenth of the bound':
        t = factor / (10 if tenth else 1) * (1 - Fraction(1, 2 ** 52)) - Fraction(1 + Fraction(1, 2 ** 40)) / 8
        judge('pbwq__square_limit', gappa('{ t in [%s, 1b2000] -> t * (1 - %s) - 2 * (1 + 16b-53) >= 0 }'
                                        % (g(rounded(t, math.floor)), g(up(error * 2)))), tenth)
    Value.bits = 53


def vector_by(name, a, b):
    result = 'c' if name.endswith('cross') else 'a'
    local = dict(zip(read(name)[0], (1, copy.copy(a), b)), **{'c': Rows()})
    return run(name, local, [result + axis for axis in ('.x', '.y', '.z')])[1][result]


def centres():
    """In pairs, from sites relative to a query.  The bound is stated at the head of >>centres."""
    bits = int(re.search(r'error of the determinant and of each numerator of a centre is at\s+most 2\^-(\d+) times',
                         HEADER).group(1))
    ENV['pbwq__number'] = lambda head: Pair(0, 0)
    define('pbwq__add', 'pbwq__sub', 'pbwq__mul', 'pbwq__vector_dot', 'pbwq__vector_area')
    for name in 'sub', 'add', 'times', 'cross':
        ENV['pbwq__vector_' + name] = lambda fine, a, b, name=name: vector_by('pbwq__vector_' + name, a, b)
    for dim in (2, 3):
        site, row, lift = Rows(), Every(None), Every(None)
        site.at, site.weight = Rows(), Pair(0, 0)
        site.at.x = site.at.y = Pair(U * (1 + U), 0)
        site.at.z = site.at.x if dim == 3 else Pair(0, 0, 0)
        run('pbwq__cavity_centre', dict(fine=1, site=site, base=site, k=0, row=row, lift=lift),
            ['weight', 'row[k]', 'lift[k]'])
        names = ['det'] + (['yz', 'sum'] if dim == 3 else ['sum.x', 'sum.y'])
        local = run('pbwq__centre_of', dict(fine=1, dim=dim, row=row, lift=lift, sum=Rows()), names)[1]
        for name, det in ('det', local['det']), ('sum', local['sum'].x):
            prove('pbwq__centre_of %d %s' % (dim, name), det.head, Value(0, det.P / 2 ** bits))


def apexes():
    """The planes of >>apex, by which >>verify judges facets too, and what its vectors are certain of."""
    least = literal('pbwl__plane_of', r'height = ([-\d.e]+)')
    define('pbwl__row_dot', 'pbwl__side_limit', 'pbwl__conflict_limit')
    for dim in (2, 3):
        plane, row = Rows(), [None] * 4
        plane.origin, plane.normal = [Number(1)] * dim + [Number(0)], [None] * 3
        local = dict(plane=plane, x=plane.origin, dim=dim, row=row)
        h = run('pbwl__plane_row', local, ['k', 'weight', 'square', 'row[k]', 'row[dim]', 'return'])[0]
        scaled(row[dim], h)
        rows, scale = dict(a=row, b=row, c=row, dim=dim), least * (root(least) if dim == 3 else 1)
        cross = normal = [None] * 3
        if dim == 2:
            run('pbwl__facet_normal', dict(rows, normal=normal), ['normal[0]', 'normal[1]'])
            names = ['plane.normal[0]', 'plane.normal[1]', 'return']
        else:
            run('pbwl__cross_row', dict(rows, x=cross), ['x[0]', 'x[1]', 'x[2]'])
            names = ['k', 'plane.normal[k]']
        local = dict(rows, plane=plane, normal=normal, ac=cross, ba=cross)
        run('pbwl__plane_set', local, ['plane.orientation'] + names)
        plane.height = h
        prove('pbwl__plane_of %d' % dim, plane.orientation, ENV['pbwl__side_limit'](h, dim), scale, True)
        side = ENV['pbwl__row_dot'](row, normal, dim)
        prove('pbwl__facet_apex %d' % dim, side, ENV['pbwl__side_limit'](h, dim), scale, True)
        local = run('pbwl__plane_conflict', dict(plane=plane, row=row + [h], dim=dim), ['det', 'limit'])[1]
        prove('pbwl__plane_conflict %d' % dim, local['det'], local['limit'], least * scale, True)


def ears():
    plane, row, name = Rows(), [None] * 4, 'pbwl__ear_spans'
    plane.origin = [Number(1)] * 3 + [Number(0)]
    local = dict(plane=plane, x=plane.origin, dim=3, row=row)
    height = run('pbwl__plane_row', local, ['k', 'weight', 'square', 'row[k]', 'row[dim]', 'return'])[0]
    scaled(row[3], height)
    spare = (height - row[3]) - row[3]                   # it makes up for what a height has more than the lift
    spare.P = Fraction(0)
    names = [c + d for c, d in ('ab', 'ac', 'ad', 'bc', 'bd', 'cd')] + ['abc', 'abd', 'acd', 'bcd', 'h', 'h3']
    local = run(name, dict(a=row, b=row, c=row, d=row, spare=spare),
                names + ['side', 'side_error', 'power', 'power_error'])[1]
    least = literal('pbwl__list_ears', r'spare = ([-\d.e]+)')
    prove(name + ' side', local['side'], local['side_error'], least * root(least))
    prove(name + ' power', local['power'], local['power_error'], least ** 2 * root(least))
    # t = P / Q, computed as p / q, with errors of at most e and f <= q / LEAST, is at most (e + t f) / (q - f) from
    # that.  Here r = f / q; q is at most 8 h^(3/2).  What ERROR adds to e and t r outweighs six roundings of t.
    factor, most = Fraction(constant('PBW__TIME_ERROR')), Fraction(constant('PBW__TIME_LEAST'))
    for tenth in '', ', a tenth of the bound':
        r = Fraction(ENV['PBW__EAR_ERROR']) / (80 if tenth else 8)
        judge(name + ' time', gappa('{ r in [%s, 1] -> r * (%s * (1 - 16b-53) - %s) >= 6b-53 }'
                                    % (g(rounded(r, math.floor)), g(rounded(factor, math.floor)),
                                       g(up(most / (most - 1))))), tenth)


def depths():
    define('pbw__dot4')
    name = 'pbwl__depths4'
    least = literal(name, r'pbw__splat\((1e-[-\d.e]+)\)')
    for dim in (2, 3):
        r = vectors(dim)
        r.dim, H = dim, [None] * 4
        local = dict(origin=r, a=r, b=r, c=r, h=r.height, H=H)
        if dim == 2:                                     # permanents of at most |a| |b|
            local = run(name, local, ['aa', 'bb', 'ab', 'side', 'return'])[1]
            scaled(local['aa'], local['bb'], local['ab'], local['side'])
        names = ['H[%d]' % i for i in range(dim + 1)] + ['return']
        names += [a + c for a in 'abcn' for c in 'xyz'] + ['side'] if dim == 3 else []
        side = run(name, local, names)[1]['side']
        power, below = r.height * r.height, least ** dim
        power = power * r.height if dim == 3 else power
        for i in 0, dim:
            prove('pbwl__depths4 %d H%d' % (dim, i), H[i], power * ENV['PBWL__DEPTH%d_ERROR' % dim], below)
        power = power * constant('PBWL__DEPTH%d_LEAST' % dim)
        prove('pbwl__depths4 %d V' % dim, side, power * constant('PBWL__DEPTH_V_ERROR') ** 2, root(below), True)
    number = [Fraction(constant('PBWL__DEPTH_' + c)) for c in ('V_ERROR', 'ERROR', 'LOST', 'MOST')]
    for tenth in '', ', a tenth of the bound':
        # of V and the exact V, v times as large; x = v or -v, the quotient 1 / V and their product are rounded
        for sign in 1, -1:
            text = ('d = mul_rel<53>(add_rel<53>(%d * v, 0), mul_rel<53>(1, 1));\n'
                    'r = add_rel<24>(add_rel<53>(d, -mul_rel<53>(|d|, %s)), 0);\n'
                    '{ v - 1 in [-%s, %s] -> r <= %d }\nv -> 1 + (v - 1);\n'
                    % (sign, g(rounded(number[1], math.floor)), g(up(number[0])), g(up(number[0])), sign))
            judge('pbwl__depths_of %d' % sign, gappa(text), tenth)
        judge('pbwl__depths_of lost', gappa('{ H in [0, %s] -> 37 * H * 1b-1075 + 1b-150 <= %s }'
                                             % (g(up(number[3])), g(rounded(number[2], math.floor)))), tenth)
        number[1], number[2] = number[1] / 10, number[2] / 10


filters()
pairs()
walks()
cavities()
queries()
centres()
apexes()
ears()
depths()
for line in ('{ H in [0, %s] -> 24 * (H * H * sqrt(H)) <= 1b53 }' % g(Fraction(constant('PBW__EXACT_HEIGHT3'))),
             '{ H in [0, %s] -> 6 * (H * H) <= 1b53 }' % g(Fraction(constant('PBW__EXACT_HEIGHT2')))):
    report(line, gappa(line))
print('%d passed, %d failed, 0 skipped' % (len(passed), len(failed)))
sys.exit(len(failed) > 0)
