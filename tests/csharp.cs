/* csharp.cs: examples/csharp/Pbw.cs against what pbw.h promises; see csharp.sh. */
using System;
using System.Collections.Generic;
using System.Linq;
using System.Reflection;
using System.Runtime.InteropServices;

public static class Tests
{
    private static int passed, failed;

    private static void Check(string name, bool holds)
    {
        passed += holds ? 1 : 0;
        failed += holds ? 0 : 1;
        if (!holds) {
            Console.WriteLine("FAILED " + name);
        }
    }

    private static T Thrown<T>(Action action) where T : Exception
    {
        try {
            action();
        } catch (T e) {
            return e;
        }
        return null;
    }

    private static double[] Random(int count, int seed)
    {
        Random random = new Random(seed);
        double[] result = new double[count];
        for (int i = 0; i < count; i++) {
            result[i] = random.NextDouble();
        }
        return result;
    }

    private static bool NeighborsAgree(Pbw t)
    {
        int corners = t.Dim + 1;
        for (int i = 0; i < t.Neighbors.Length; i++) {
            if (t.Neighbors[i] != Pbw.None) {
                int back = Array.IndexOf(t.Neighbors, (uint)(i / corners), (int)t.Neighbors[i] * corners, corners);
                if (back < 0) {
                    return false;
                }
            }
        }
        return true;
    }

    private static int Bytes(string structure)
    {
        return Marshal.SizeOf(typeof(Pbw).GetNestedType(structure, BindingFlags.NonPublic));
    }

    /* sizes: those of pbw_options and pbw_mesh in C. */
    public static int Main(string[] sizes)
    {
        Check("Options is as large as pbw_options", Bytes("Options") == int.Parse(sizes[0]));
        Check("Mesh is as large as pbw_mesh", Bytes("Mesh") == int.Parse(sizes[1]));
        double[] points = Random(30000, 1);
        foreach (int dim in new int[] { 2, 3 }) {
            Pbw one = new Pbw(dim, points, null, 1), all = new Pbw(dim, points);
            Check("neighbours in " + dim + "D", one.Simplices.Length > 0 && NeighborsAgree(one));
            Check("every point in " + dim + "D is a vertex", Array.IndexOf(one.Incident, Pbw.None) < 0);
            Check("threads in " + dim + "D", one.Hash == all.Hash && one.Hash != 0 &&
                  one.Simplices.SequenceEqual(all.Simplices) && one.Neighbors.SequenceEqual(all.Neighbors));
        }
        Pbw weighted = new Pbw(3, points, Random(10000, 2));
        Check("hidden points", weighted.Hidden > 0 && Array.FindAll(weighted.Incident, i => i == Pbw.None).Length ==
              weighted.Hidden);
        Pbw twice = new Pbw(2, new double[] { 0,0,  1,0,  0,1,  1,0 });
        Check("duplicates", twice.Duplicates == 1 && twice.Canonical[3] == 1);

        PbwException degenerate = Thrown<PbwException>(() => new Pbw(2, new double[] { 0,0,  1,1,  2,2 }));
        Check("points on a line", degenerate != null && degenerate.Status == 1 && degenerate.Message.Length > 10);
        Check("NaN", Thrown<PbwException>(() => new Pbw(2, new double[] { 0,0,  1,0,  0,double.NaN })) != null);
        Check("weights", Thrown<ArgumentException>(() => new Pbw(3, points, new double[9])) != null);
        Check("half a point", Thrown<ArgumentException>(() => new Pbw(3, new double[10])) != null);

        int calls = 0;
        new Pbw(3, points, null, 0, (stage, done) => { calls++; return stage >= 0 && done >= 0 && done <= 1; });
        Check("progress", calls > 0);
        PbwException cancelled = Thrown<PbwException>(() => new Pbw(3, points, null, 0, (stage, done) => false));
        Check("cancelled", cancelled != null && cancelled.Status == 2);
        Check("an exception comes out", Thrown<KeyNotFoundException>(() =>
            new Pbw(3, points, null, 0, (stage, done) => { throw new KeyNotFoundException(); })) != null);

        Console.WriteLine("{0} passed, {1} failed, 0 skipped", passed, failed);
        return failed > 0 ? 1 : 0;
    }
}
