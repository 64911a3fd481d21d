/* Pbw.cs: pbw from C#, by the shared library of `make install` (or of `make build/libpbw.so`): copy this file, leave
   out Main.
       mcs Pbw.cs && LD_LIBRARY_PATH=../../build mono Pbw.exe        (or csc, or a project of dotnet) */
using System;
using System.Runtime.InteropServices;

public sealed class PbwException : Exception
{
    public readonly int Status;
    public PbwException(int status, string text) : base(text) { Status = status; }
}

/* A Delaunay triangulation, or a regular one with weights: plain arrays, which outlive the library's. */
public sealed class Pbw
{
    public const uint None = 0xffffffff;             /* beyond the hull; not a vertex */
    public readonly int Dim;
    public readonly uint[] Simplices, Neighbors;     /* dim + 1 for each simplex */
    public readonly uint[] Incident, Canonical;      /* for each point */
    public readonly int Duplicates, Hidden;
    public readonly ulong Hash;

    /* points: dim coordinates each.  progress: called with the stage (order, build, output) and the share of it that
       is done; if it returns false, or throws, the triangulation ends. */
    public Pbw(int dim, double[] points, double[] weights = null, int threads = 0,
               Func<int, double, bool> progress = null)
    {
        if (points == null) {
            throw new ArgumentNullException("points");
        }
        if ((dim != 2 && dim != 3) || points.Length % dim != 0) {
            throw new ArgumentException("dim is 2 or 3, and points have dim coordinates each");
        }
        int count = points.Length / dim;
        if (weights != null && weights.Length != count) {
            throw new ArgumentException("weights must have " + count + " numbers, not " + weights.Length);
        }
        Exception thrown = null;
        Progress call = (user, stage, done) => {
            try {
                return progress(stage, done) ? 0 : 1;
            } catch (Exception e) {                  /* may not go through the library's frames */
                thrown = e;
                return 1;
            }
        };
        Options options = new Options { Threads = threads, Progress = progress == null ? null : call };
        Mesh mesh = new Mesh();
        int status = pbw_triangulate(dim, points, weights, (UIntPtr)count, ref options, ref mesh);
        GC.KeepAlive(call);
        try {
            if (thrown != null) {
                throw thrown;
            }
            if (status != 0) {
                throw new PbwException(status, Marshal.PtrToStringAnsi(pbw_status_string(status)));
            }
            int corners = checked((int)mesh.SimplexCount * (dim + 1));
            Dim = dim;
            Simplices = Copy(mesh.Simplices, corners);
            Neighbors = Copy(mesh.Neighbors, corners);
            Incident = Copy(mesh.Incident, count);
            Canonical = Copy(mesh.Canonical, count);
            Duplicates = (int)mesh.DuplicateCount;
            Hidden = (int)mesh.HiddenCount;
            Hash = pbw_hash(ref mesh, IntPtr.Zero);
        } finally {
            pbw_free(ref mesh);
        }
    }

    private static uint[] Copy(IntPtr from, int count)
    {
        int[] bits = new int[count];
        Marshal.Copy(from, bits, 0, count);
        uint[] result = new uint[count];
        Buffer.BlockCopy(bits, 0, result, 0, checked(count * 4));
        return result;
    }

    /* The interface of pbw.h, field by field. */
    [UnmanagedFunctionPointer(CallingConvention.Cdecl)]
    private delegate int Progress(IntPtr user, int stage, double done);

    [StructLayout(LayoutKind.Sequential)]
    private struct Options
    {
        public int Threads;
        public uint Flags;
        public UIntPtr Stride, WeightStride, MemoryLimit;
        public IntPtr Resize, Run;
        public Progress Progress;
        public IntPtr ResizeUser, RunUser, ProgressUser, Backend, Trace, Message;
        public UIntPtr MessageSize;
    }

    [StructLayout(LayoutKind.Sequential)]
    private struct Statistics
    {
        public double OrderSeconds, BuildSeconds, OutputSeconds;
        public UIntPtr PeakBytes, WalkSteps, ConflictTests, ExactTests, Created;
        public int Threads;
        public UIntPtr Rounds, Postponed, Serial;
        public int ByBackend;
    }

    [StructLayout(LayoutKind.Sequential)]
    private struct Mesh
    {
        public int Dim;
        public UIntPtr PointCount, SimplexCount;
        public IntPtr Simplices, Neighbors, Incident, Canonical;
        public UIntPtr DuplicateCount, HiddenCount;
        public IntPtr Original, Points, Weights;
        public Statistics Statistics;
        public IntPtr Memory;
    }

    [DllImport("pbw", CallingConvention = CallingConvention.Cdecl)]
    private static extern int pbw_triangulate(int dim, double[] points, double[] weights, UIntPtr count,
                                              ref Options options, ref Mesh mesh);
    [DllImport("pbw", CallingConvention = CallingConvention.Cdecl)]
    private static extern void pbw_free(ref Mesh mesh);
    [DllImport("pbw", CallingConvention = CallingConvention.Cdecl)]
    private static extern ulong pbw_hash(ref Mesh mesh, IntPtr options);
    [DllImport("pbw", CallingConvention = CallingConvention.Cdecl)]
    private static extern IntPtr pbw_status_string(int status);
}

public static class Program
{
    public static void Main()
    {
        Pbw square = new Pbw(2, new double[] { 0,0,  1,0,  1,1,  0,1,  0.5,0.5 });
        Console.WriteLine("{0} triangles", square.Simplices.Length / 3);
        for (int i = 0; i < square.Simplices.Length; i += 3) {
            Console.WriteLine("{0} {1} {2}", square.Simplices[i], square.Simplices[i + 1], square.Simplices[i + 2]);
        }
    }
}
