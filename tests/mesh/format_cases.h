/* SPDX-License-Identifier: BSD-3-Clause */
/* SPDX-FileCopyrightText: 2026 the softsim authors */
#pragma once
/*
 * A table of small mesh files, good and bad, and what each gets: the mesh in words, or the error.
 * Good volumes are one body or parts of it: five nodes, two tetrahedra on a common face, volume
 * 1/3. cmocka comes first.
 */
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#include "common/folder_fixture.h"
#include "common/mesh_fixture.h"
#include "mesh/mesh.h"

/* ---- pieces of files ---- */

/* MSH 2.2: gaps in tags, groups of every dimension, faces that only name nodes. */
#define HEAD2  "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n"
#define NAMES  "$PhysicalNames\n2\n2 7 \"base\"\n3 1 \"soft tissue\"\n$EndPhysicalNames\n"
#define NODES2 "$Nodes\n5\n1 0 0 0\n2 1 0 0\n30 0 1 0\n7 0 0 1\n90 0 0 -1\n$EndNodes\n"
#define ELEMENTS2                                                                                  \
    "$Elements\n5\n1 15 2 3 1 90\n2 1 2 0 1 1 2\n3 2 2 7 1 1 2 30\n4 4 2 1 1 1 2 30 7\n"           \
    "9 4 2 1 1 1 30 2 90\n$EndElements\n"
#define MSH2  HEAD2 NAMES NODES2 ELEMENTS2
#define BODY  "5 nodes 6 triangles 2 tetrahedra volume 0.333333"
#define BODY2 BODY " {point-3 1} {base 3} {soft tissue 5} -points 1 -lines 1 -triangles 1"
#define MSH1                                                                                       \
    "$NOD\n5\n1 0 0 0\n2 1 0 0\n30 0 1 0\n7 0 0 1\n90 0 0 -1\n$ENDNOD\n$ELM\n3\n1 2 7 1 3 1 2 "    \
    "30\n2 4 1 1 4 1 2 30 7\n3 4 1 1 4 1 30 2 90\n$ENDELM\n"

/* MSH 4.1: two blocks of nodes, one parametric; an entity in two groups, one of them reversed. */
#define HEAD4 "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n"
#define ENTITIES4                                                                                  \
    "$Entities\n1 0 1 1\n1 0 0 0 0\n5 0 0 0 1 1 0 1 7 0\n1 0 0 0 1 1 1 2 1 -3 1 5\n$EndEntities\n"
#define NODES4                                                                                     \
    "$Nodes\n2 5 1 90\n2 5 1 3\n1\n2\n30\n0 0 0 0 0\n1 0 0 1 0\n0 1 0 0 1\n3 1 0 2\n7\n90\n"       \
    "0 0 1\n0 0 -1\n$EndNodes\n"
#define ELEMENTS4                                                                                  \
    "$Elements\n3 4 1 9\n0 1 15 1\n1 1\n2 5 2 1\n2 1 2 30\n3 1 4 2\n3 1 2 30 7\n9 1 30 2 90\n"     \
    "$EndElements\n"
#define MSH4  HEAD4 NAMES ENTITIES4 NODES4 ELEMENTS4
#define BODY4 BODY " {base 3} {soft tissue 5} {volume-3 5} -points 1 -triangles 1"

/* TetGen, from 1 and from 0. */
#define NODE1                                                                                      \
    "# points\n5 3 1 1\n\n1 0 0 0 0.5 1 # first\n2 1 0 0 0.5 1\n3 0 1 0 0.5 1\n4 0 0 1 0.5 0\n"    \
    "5 0 0 -1 .5 -2\n# made by hand\n"
#define ELE1      "2 4 1\n1 1 2 3 4 7\n2 1 3 2 5 8\n"
#define NODE0     "5 3 0 0\n0 0 0 0\n1 1 0 0\n2 0 1 0\n3 0 0 1\n4 0 0 -1\n"
#define ELE0      "2 4 0\n0 0 1 2 3\n1 0 2 1 4\n"
#define BODY_TET1 BODY " {marker=-2 1} {marker=0 1} {marker=1 3} {region=7 4} {region=8 4}"

/* Legacy VTK, before version 5 and since. */
#define VTK3     "# vtk DataFile Version 3.0\na title\nASCII\n"
#define VTK5     "# vtk DataFile Version 5.1\n\nASCII\n"
#define POINTS   "POINTS 5 double\n0 0 0 1 0 0\n0 1 0\n0 0 1 0 0 -1\n"
#define GRID3    VTK3 "DATASET UNSTRUCTURED_GRID\n"
#define GRID5    VTK5 "DATASET UNSTRUCTURED_GRID\n"
#define CELLS3   "CELLS 3 14\n4 0 1 2 3\n3 0 1 2\n4 0 2 1 4\n\nCELL_TYPES 3\n10\n5\n10\n"
#define META     "METADATA\nINFORMATION 1\nNAME L2_NORM_RANGE LOCATION vtkDataArray\nDATA 2 0 1\n\n"
#define DATA     "CELL_DATA 3\nSCALARS region int 1\nLOOKUP_TABLE default\n7 9 8\n"
#define VTKGRID  GRID3 POINTS META CELLS3 DATA
#define BODY_VTK BODY " {region=7 4} {region=8 4} {region=9 3} -triangles 1"
#define CELLS5                                                                                     \
    "CELLS 4 11\nOFFSETS vtktypeint64\n0 4 7 11\nCONNECTIVITY vtktypeint64\n0 1 2 3 0 1 2 0 2 1 "  \
    "4\nCELL_TYPES 3\n10\n5\n10\n"
#define POLY     VTK3 "DATASET POLYDATA\nPOINTS 4 float\n0 0 0 1 0 0 0 1 0 0 0 1\n"
#define POLYGONS "POLYGONS 4 16\n3 0 2 1\n3 0 1 3\n3 1 2 3\n3 2 0 3\n"
#define TETRA    "4 nodes 4 triangles volume 0.166667"

/* XML. */
#define XML "<?xml version=\"1.0\"?>\n<!-- a > comment -->\n"
#define FILE_BEGIN                                                                                 \
    "<VTKFile type=\"UnstructuredGrid\" version='1.0' byte_order=\"LittleEndian\">\n"              \
    "<UnstructuredGrid>\n<FieldData><DataArray type=\"Int32\" Name=\"n\">1</DataArray>"            \
    "</FieldData>\n"
#define PIECE "<Piece NumberOfPoints=\"5\" NumberOfCells=\"3\">\n"
#define POINT_DATA                                                                                 \
    "<PointData Scalars=\"fixed\"><DataArray type=\"Int32\" Name=\"a &lt; b\" format=\"ascii\">\n" \
    "0 0 1 1 1</DataArray><DataArray type=\"Float32\" Name=\"t\">1 2 3 4 5</DataArray>"            \
    "</PointData>\n"
#define XML_POINTS                                                                                 \
    "<Points><DataArray type=\"Float64\" NumberOfComponents=\"3\" format=\"ascii\">\n"             \
    "<InformationKey name=\"L2\" location=\"v\" length=\"1\"><Value index=\"0\">0</Value>"         \
    "</InformationKey>0 0 0 1 0 0 0 1 0\n0 0 1 0 0 -1\n</DataArray></Points>\n"
#define XML_CELLS                                                                                  \
    "<Cells><DataArray type=\"Int64\" Name=\"connectivity\" format=\"ascii\">0 1 2 3 0 1 2\n"      \
    "0 2 1 4</DataArray><DataArray type=\"Int64\" Name=\"offsets\">4 7 11</DataArray>\n"           \
    "<DataArray type=\"UInt8\" Name=\"types\" format=\"ascii\">10 5 10</DataArray></Cells>\n"
#define FILE_END "</Piece></UnstructuredGrid></VTKFile>\n"
#define VTU      XML FILE_BEGIN PIECE POINT_DATA XML_POINTS XML_CELLS FILE_END
#define BODY_VTU BODY " {a < b=0 2} {a < b=1 3} -triangles 1"

/* Ten nodes, each order's own: 01 12 02 03 23 13 of Gmsh, 01 12 02 03 13 23 of VTK, 23 03 01 12 13
 * 02 of TetGen. */
#define TEN_PLACES(n1, n2, n3, n4, n5, n6, n7, n8, n9, n10)                                        \
    n1 "0 0 0\n" n2 "2 0 0\n" n3 "0 2 0\n" n4 "0 0 2\n" n5 "1 0 0\n" n6 "1 1 0\n" n7 "0 1 0\n" n8  \
       "0 0 1\n" n9 "1 0 1\n" n10 "0 1 1\n"
#define TEN_LINES  TEN_PLACES("1 ", "2 ", "3 ", "4 ", "5 ", "6 ", "7 ", "8 ", "9 ", "10 ")
#define TEN_BARE   TEN_PLACES("", "", "", "", "", "", "", "", "", "")
#define TEN_NODES2 "$Nodes\n10\n" TEN_LINES "$EndNodes\n"
#define TEN_NODE1  "10 3 0 0\n" TEN_LINES
#define TEN_POINTS "POINTS 10 double\n" TEN_BARE
#define TEN        "10 nodes 16 triangles 1 tetrahedra volume 1.33333"
#define SECOND2                                                                                    \
    HEAD2                                                                                          \
    "$PhysicalNames\n2\n1 4 \"edge\"\n2 7 \"face\"\n$EndPhysicalNames\n" TEN_NODES2                \
    "$Elements\n3\n1 8 2 4 1 1 2 5\n2 9 2 7 1 1 3 2 7 6 5\n3 11 2 1 1 1 2 3 4 5 6 7 8 10 9\n"      \
    "$EndElements\n"
#define SECOND4                                                                                    \
    HEAD4 "$Entities\n0 0 1 1\n5 0 0 0 1 1 0 1 7 0\n1 0 0 0 1 1 1 0 0\n$EndEntities\n"             \
          "$Nodes\n1 10 1 10\n3 1 0 10\n1\n2\n3\n4\n5\n6\n7\n8\n9\n10\n" TEN_BARE                  \
          "$EndNodes\n$Elements\n2 2 1 2\n2 5 9 1\n1 1 3 2 7 6 5\n3 1 11 1\n"                      \
          "2 1 2 3 4 5 6 7 8 10 9\n$EndElements\n"
#define SECONDVTK                                                                                  \
    GRID3 TEN_POINTS "CELLS 2 18\n10 0 1 2 3 4 5 6 7 8 9\n6 0 2 1 6 5 4\nCELL_TYPES 2\n24\n22\n"   \
                     "CELL_DATA 2\nSCALARS region int 1\nLOOKUP_TABLE default\n2 3\n"
#define SECONDVTU                                                                                  \
    "<VTKFile type=\"UnstructuredGrid\"><UnstructuredGrid>"                                        \
    "<Piece NumberOfPoints=\"10\" NumberOfCells=\"1\"><Points><DataArray type=\"Float64\" "        \
    "NumberOfComponents=\"3\">" TEN_BARE "</DataArray></Points><Cells>"                            \
    "<DataArray type=\"Int64\" Name=\"connectivity\">0 1 2 3 4 5 6 7 8 9</DataArray>"              \
    "<DataArray type=\"Int64\" Name=\"offsets\">10</DataArray>"                                    \
    "<DataArray type=\"UInt8\" Name=\"types\">24</DataArray></Cells></Piece></UnstructuredGrid>"   \
    "</VTKFile>\n"

/* A unit cube, a prism of half its volume beside it, a pyramid of a third on it and a tetrahedron
 * of a sixth on the prism's end: 6 + 3 + 2 + 1 tetrahedra. In MSH nodes are numbered downwards; the
 * VTK files have the cube as a voxel and wind the prism the other way. */
#define CELL_PLACES(n1, n2, n3, n4, n5, n6, n7, n8, n9, n10, n11, n12)                             \
    n12 "1 -1 0\n" n11 "0.5 0.5 2\n" n10 "2 1 0\n" n9 "2 0 0\n" n8 "0 1 1\n" n7 "1 1 1\n" n6       \
        "1 0 1\n" n5 "0 0 1\n" n4 "0 1 0\n" n3 "1 1 0\n" n2 "1 0 0\n" n1 "0 0 0\n"
#define CELL_BARE CELL_PLACES("", "", "", "", "", "", "", "", "", "", "", "")
#define CELL_NODES2                                                                                \
    "$Nodes\n12\n" CELL_PLACES("1 ", "2 ", "3 ", "4 ", "5 ", "6 ", "7 ", "8 ", "9 ", "10 ", "11 ", \
                               "12 ") "$EndNodes\n"
#define CELL_ELEMENTS2                                                                             \
    "$Elements\n4\n1 5 2 5 1 1 2 3 4 5 6 7 8\n2 6 2 5 1 2 6 9 3 7 10\n3 7 2 5 1 5 6 7 8 11\n"      \
    "4 4 2 0 1 2 9 6 12\n$EndElements\n"
#define CELL_MSH4                                                                                  \
    HEAD4 "$Nodes\n1 12 1 12\n3 1 0 12\n12\n11\n10\n9\n8\n7\n6\n5\n4\n3\n2\n1\n" CELL_BARE         \
          "$EndNodes\n$Elements\n4 4 1 4\n3 1 5 1\n1 1 2 3 4 5 6 7 8\n3 1 6 1\n2 2 6 9 3 7 10\n"   \
          "3 1 7 1\n3 5 6 7 8 11\n3 1 4 1\n4 2 9 6 12\n$EndElements\n"
#define CELL_VTK                                                                                   \
    GRID3 "POINTS 12 double\n" CELL_BARE "CELLS 4 27\n8 11 10 8 9 7 6 4 5\n6 10 3 6 9 2 5\n"       \
          "5 7 6 5 4 1\n4 10 3 6 0\nCELL_TYPES 4\n11\n13\n14\n10\n"
#define CELL_VTU                                                                                   \
    "<VTKFile type=\"UnstructuredGrid\"><UnstructuredGrid>"                                        \
    "<Piece NumberOfPoints=\"12\" NumberOfCells=\"4\"><Points><DataArray type=\"Float64\" "        \
    "NumberOfComponents=\"3\">" CELL_BARE "</DataArray></Points><Cells>"                           \
    "<DataArray type=\"Int64\" Name=\"connectivity\">11 10 8 9 7 6 4 5 10 3 6 9 2 5 7 6 5 4 1 "    \
    "10 3 6 0</DataArray><DataArray type=\"Int64\" Name=\"offsets\">8 14 19 23</DataArray>"        \
    "<DataArray type=\"UInt8\" Name=\"types\">11 13 14 10</DataArray></Cells></Piece>"             \
    "</UnstructuredGrid></VTKFile>\n"
#define CELLS      "12 nodes 20 triangles 12 tetrahedra volume 2"
#define CELL_KINDS " /hexahedra 1 /prisms 1 /pyramids 1"

/* OFF: a tetrahedron; with colours, comments and counts behind the word; a cube of quads; a prism
 * over a five-sided face with a dent, of area 2.5. */
#define OFF_PLACES "0 0 0\n1 0 0\n0 1 0\n0 0 1\n"
#define OFF_FACES  "3 0 2 1\n3 0 1 3\n3 1 2 3\n3 2 0 3\n"
#define OFF_COLOURED                                                                               \
    "COFF 4 4 0 # by hand\n\n0 0 0 255 0 0 255\n1 0 0 1 1 1 1\n# 1\n0 1 0 0 0 0 1\n"               \
    "0 0 1 0 0 0 0\n3 0 2 1 255 0 0\n3 0 1 3 0.5 0.5 0.5 1 # a colour\n3 1 2 3\n\n3 2 0 3 7\n"
#define OFF_CUBE                                                                                   \
    "OFF\n8 6\n0 0 0\n1 0 0\n1 1 0\n0 1 0\n0 0 1\n1 0 1\n1 1 1\n0 1 1\n4 0 3 2 1\n4 4 5 6 7\n"     \
    "4 0 1 5 4\n4 1 2 6 5\n4 2 3 7 6\n4 3 0 4 7\n"
#define OFF_PRISM                                                                                  \
    "OFF\n10 7 0\n0 0 0\n2 0 0\n2 2 0\n1 0.5 0\n0 2 0\n0 0 1\n2 0 1\n2 2 1\n1 0.5 1\n0 2 1\n"      \
    "5 4 3 2 1 0\n5 5 6 7 8 9\n4 0 1 6 5\n4 1 2 7 6\n4 2 3 8 7\n4 3 4 9 8\n4 4 0 5 9\n"

/* ---- the table ---- */

typedef enum change {
    AS_IS,
    CRLF,   /* every line ends so */
    NO_END, /* no newline behind the last line */
    CUT     /* ends behind the first `cut` */
} change;

typedef struct file_case {
    const char *name, *text; /* text NULL: binary, by make_binary */
    const char *expected;    /* good: all of the summary; bad: "!" and a part of the error */
    change change;
    const char *cut;
    const char *other_name, *other_text; /* TetGen's second file */
} file_case;

#define PAIR(name_, text_, change_, cut_, other_, other_text_, expected_)                          \
    {                                                                                              \
        .name = (name_), .text = (text_), .expected = (expected_), .change = (change_),            \
        .cut = (cut_), .other_name = (other_), .other_text = (other_text_)                         \
    }
#define CHANGED(name, text, change, expected) PAIR(name, text, change, NULL, NULL, NULL, expected)
#define PLAIN(name, text, expected)           CHANGED(name, text, AS_IS, expected)
#define CUT_AT(name, text, cut, expected)     PAIR(name, text, CUT, cut, NULL, NULL, expected)

static const file_case cases[] = {
    /* Gmsh 1 and 2 */
    PLAIN("plain.msh", MSH2, BODY2),
    CHANGED("crlf.msh", MSH2, CRLF, BODY2),
    CHANGED("no-end.msh", MSH2, NO_END, BODY2),
    PLAIN("any-name.dat", MSH2, BODY2),
    PLAIN("mark.msh", "\xEF\xBB\xBF" MSH2, BODY2),
    PLAIN("sections.msh", HEAD2 "$Comments\nby hand\n$EndComments\n" NODES2 ELEMENTS2,
          BODY " {point-3 1} {surface-7 3} {volume-1 5} -points 1 -lines 1 -triangles 1"),
    PLAIN("one.msh", MSH1, BODY " {surface-7 3} {volume-1 5} -triangles 1"),
    CHANGED("one-crlf.msh", MSH1, CRLF, BODY " {surface-7 3} {volume-1 5} -triangles 1"),
    PLAIN("mixed.msh",
          HEAD2 NODES2
          "$Elements\n2\n1 5 2 0 0 1 2 30 7 1 2 30 7\n2 4 2 0 0 1 2 30 7\n$EndElements\n",
          "!mixed.msh:14: a hexahedron that has no volume: correct its nodes, or their order"),
    PLAIN("left.msh",
          HEAD2 NODES2 "$Elements\n2\n1 16 2 0 0 1 2 30 7 1 2 30 7\n2 4 2 0 0 1 2 30 7\n"
                       "$EndElements\n",
          "5 nodes 4 triangles 1 tetrahedra volume 0.166667 -elements of higher order 1"),
    PLAIN("quads.msh", HEAD2 NODES2 "$Elements\n1\n1 3 2 0 0 1 2 30 7\n$EndElements\n",
          "5 nodes 2 triangles 1 quads"),
    PLAIN("lines.msh",
          HEAD2 NODES2 "$Elements\n3\n1 1 2 0 0 1 2\n2 1 2 0 0 2 7\n3 15 2 0 0 7\n$EndElements\n",
          "!lines.msh: it holds 2 lines and 1 points and no triangle, quad or cell of a volume, so "
          "there is no body in it"),
    PLAIN("hexahedra.msh", HEAD2 NODES2 "$Elements\n1\n1 5 2 0 0 1 2 30 7 1 2 30 7\n$EndElements\n",
          "!hexahedra.msh:14: a hexahedron that has no volume"),
    PLAIN("second-hexahedra.msh", HEAD2 NODES2 "$Elements\n1\n1 17 2 0 0 1 2 30 7\n$EndElements\n",
          "!it holds 1 elements of higher order and nothing that makes a body, element 0 (line 14) "
          "is of type 17 (second-order hexahedron): write triangles, quads"),
    /* Cells that are split: a cube, a prism beside it, a pyramid on it, a tetrahedron on the prism
     */
    PLAIN("cells.msh", HEAD2 CELL_NODES2 CELL_ELEMENTS2, CELLS " {volume-5 11}" CELL_KINDS),
    CHANGED("cells-crlf.msh", HEAD2 CELL_NODES2 CELL_ELEMENTS2, CRLF,
            CELLS " {volume-5 11}" CELL_KINDS),
    PLAIN("cells-four.msh", CELL_MSH4, CELLS CELL_KINDS),
    PLAIN("cells.vtk", CELL_VTK, CELLS CELL_KINDS),
    PLAIN("cells.vtu", CELL_VTU, CELLS CELL_KINDS),
    PLAIN("cell-short.msh",
          HEAD2 CELL_NODES2 "$Elements\n1\n1 5 2 0 0 1 2 3 4 5 6 7\n$EndElements\n",
          "!element 0, a hexahedron: its tags and then 8 node numbers expected here"),
    PLAIN("cell-folded.msh",
          HEAD2 CELL_NODES2 "$Elements\n1\n1 5 2 0 0 1 2 4 3 5 6 7 8\n$EndElements\n",
          "!cell-folded.msh:21: a hexahedron that is folded (parts of it are inside out)"),
    PLAIN("cell-collapsed.msh",
          HEAD2 CELL_NODES2 "$Elements\n1\n1 5 2 0 0 1 2 4 4 5 6 8 8\n$EndElements\n",
          "12 nodes 8 triangles 3 tetrahedra volume 0.5 /hexahedra 1"),
    CUT_AT("cut-nodes.msh", MSH2, "30 0 1 0\n", "!cut-nodes.msh:10: 5 nodes announced, but"),
    CUT_AT("cut-names.msh", MSH2, "\"ba", "!a name in quotes"),
    CUT_AT("cut-element.msh", MSH2, "4 4 2 1 1 1",
           "!cut-element.msh:22: the text ends at element 4 of 5"),
    CUT_AT("cut-end.msh", MSH2, "30 2 90\n", "!the text ends before $EndElements"),
    PLAIN("absurd.msh", HEAD2 "$Nodes\n60000000\n1 0 0 0\n$EndNodes\n",
          "!absurd.msh:5: 60000000 nodes announced, but the rest of the file is too short"),
    PLAIN("nan.msh", HEAD2 "$Nodes\n1\n1 0 nan 0\n$EndNodes\n",
          "!node 0: its position is not finite"),
    PLAIN("inf.msh", HEAD2 "$Nodes\n1\n1 0 -inf 0\n$EndNodes\n",
          "!node 0: its position is not finite"),
    PLAIN("hex-number.msh", HEAD2 "$Nodes\n1\n1 0 0x10 0\n$EndNodes\n", "!and x y z expected here"),
    PLAIN("range.msh", HEAD2 NODES2 "$Elements\n1\n1 4 2 0 0 1 2 30 8\n$EndElements\n",
          "!range.msh:14: element 0: there is no node number 8"),
    PLAIN("negative.msh", HEAD2 NODES2 "$Elements\n1\n1 4 2 0 0 1 2 30 -7\n$EndElements\n",
          "!there is no node number -7"),
    PLAIN("binary.msh", "$MeshFormat\n2.2 1 8\n\1\n$EndMeshFormat\n",
          "!2.2 binary is not read: write"),
    PLAIN("three.msh", "$MeshFormat\n3 0 8\n$EndMeshFormat\n", "!Gmsh format 3 is not read: write"),
    PLAIN("empty.msh", "", "!empty.msh: the file is empty"),
    PLAIN("blank.msh", " \n\n", "!not a mesh that is read here"),
    /* Gmsh 4.1 */
    PLAIN("four.msh", MSH4, BODY4),
    CHANGED("four-crlf.msh", MSH4, CRLF, BODY4),
    CHANGED("four-no-end.msh", MSH4, NO_END, BODY4),
    PLAIN("four-bare.msh", HEAD4 NODES4 ELEMENTS4, BODY " -points 1 -triangles 1"),
    PLAIN("four-empty-block.msh",
          HEAD4
          "$Nodes\n2 4 1 4\n0 1 0 0\n3 1 0 4\n1\n2\n3\n4\n0 0 0\n1 0 0\n0 1 0\n0 0 1\n$EndNodes\n"
          "$Elements\n2 1 1 1\n2 1 2 0\n3 1 4 1\n1 1 2 3 4\n$EndElements\n",
          "4 nodes 4 triangles 1 tetrahedra volume 0.166667"),
    PLAIN("four-binary.msh", "$MeshFormat\n4.1 1 8\n\1\n$EndMeshFormat\n",
          "!4.1 binary is not read"),
    CUT_AT("four-cut-tags.msh", MSH4, "3\n1\n2\n", "!5 nodes announced, but"),
    CUT_AT("four-cut-places.msh", MSH4, "0 0 0 0 0\n", "!5 nodes announced, but"),
    CUT_AT("four-cut-block.msh", MSH4, "3 1 2 30 7\n", "!the text ends at element 3 of 4"),
    CUT_AT("four-cut-entity.msh", MSH4, "5 0 0 0 1", "!an entity of dimension 2 expected here"),
    PLAIN("four-count.msh", HEAD4 "$Nodes\n1 3 1 3\n3 1 0 2\n1\n2\n0 0 0\n1 0 0\n$EndNodes\n",
          "!3 nodes announced, but the blocks have 2"),
    PLAIN("four-more.msh", HEAD4 "$Nodes\n1 1 1 3\n3 1 0 2\n1\n2\n0 0 0\n1 0 0\n$EndNodes\n",
          "!1 records are left of those announced"),
    PLAIN("four-absurd.msh", HEAD4 "$Nodes\n1 900000000 1 3\n3 1 0 2\n1\n",
          "!900000000 nodes announced, but"),
    PLAIN("four-absurd-entities.msh", HEAD4 "$Entities\n2000000000 0 0 2000000000\n$EndEntities\n",
          "!4000000000 entities announced, but"),
    PLAIN("four-absurd-groups.msh",
          HEAD4 "$Entities\n1 0 0 0\n1 0 0 0 2000000000 1\n$EndEntities\n",
          "!an entity of dimension 0 expected here"),
    PLAIN("four-nan.msh", HEAD4 "$Nodes\n1 1 1 1\n3 1 0 1\n1\n0 nan 0\n$EndNodes\n",
          "!node 0: its position is not finite"),
    PLAIN("four-twice.msh", HEAD4 "$Nodes\n1 2 1 1\n3 1 0 2\n7\n7\n0 0 0\n1 0 0\n$EndNodes\n",
          "!four-twice.msh:8: node number 7 is on line 7 already"),
    PLAIN("four-range.msh", HEAD4 NODES4 "$Elements\n1 1 1 1\n3 1 4 1\n1 1 2 30 31\n$EndElements\n",
          "!element 0: there is no node number 31"),
    PLAIN("four-short.msh", HEAD4 NODES4 "$Elements\n1 1 1 1\n3 1 4 1\n1 1 2 30\n$EndElements\n",
          "!element 0, a tetrahedron: its number and then 4"),
    PLAIN("four-parts.msh", HEAD4 "$PartitionedEntities\n1\n$EndPartitionedEntities\n",
          "!a mesh in partitions is not read"),
    PLAIN("four-fourth.msh",
          HEAD4 NODES4 "$Elements\n1 1 1 1\n3 1 30 1\n1 1 2 30 7 1 2 30 7 1 "
                       "2\n$EndElements\n",
          "!type 30 (no triangle or tetrahedron)"),
    PLAIN("four-triangles.msh",
          HEAD4 NODES4 "$Elements\n1 1 1 1\n2 1 9 1\n1 1 2 30 7 1 2\n$EndElements\n",
          "!it holds 1 triangles of second order and nothing that makes a body, element 0 (line "
          "21) is of type 9 (second-order triangle): write"),
    /* Second order */
    PLAIN("second.msh", SECOND2,
          TEN " {edge 3} {face 6} {volume-1 10} -lines of second order 1 "
              "-triangles of second order 1"),
    CHANGED("second-crlf.msh", SECOND2, CRLF,
            TEN " {edge 3} {face 6} {volume-1 10} -lines of "
                "second order 1 -triangles of second order 1"),
    PLAIN("second-four.msh", SECOND4, TEN " {surface-7 6} -triangles of second order 1"),
    PLAIN("second-short.msh",
          HEAD2 TEN_NODES2 "$Elements\n1\n1 11 2 0 0 1 2 3 4 5 6 7 8 9\n$EndElements\n",
          "!element 0, a second-order tetrahedron: its tags and then 10 node numbers"),
    PLAIN("second-long.msh",
          HEAD2 TEN_NODES2 "$Elements\n1\n1 11 2 0 0 1 2 3 4 5 6 7 8 9 10 10\n$EndElements\n",
          "!element 0, a second-order tetrahedron: its tags and then 10 node numbers"),
    PLAIN("second-range.msh",
          HEAD2 TEN_NODES2 "$Elements\n1\n1 11 2 0 0 1 2 3 4 5 6 7 8 9 11\n$EndElements\n",
          "!element 0: there is no node number 11"),
    PLAIN("both.msh",
          HEAD2 TEN_NODES2 "$Elements\n2\n1 11 2 0 0 1 2 3 4 5 6 7 8 9 10\n2 4 2 0 0 1 2 3 4\n"
                           "$EndElements\n",
          "!1 cells of first order beside 1 tetrahedra of 10 nodes: mesh it all of one order"),
    PLAIN("second.vtk", SECONDVTK, TEN " {region=2 10} {region=3 6} -triangles of second order 1"),
    PLAIN("second-short.vtk",
          GRID3 TEN_POINTS "CELLS 1 10\n9 0 1 2 3 4 5 6 7 8\nCELL_TYPES 1\n24\n",
          "!cell 0, of type 24 (tetrahedra of second order), has 9 nodes: it must have 10"),
    PLAIN("second.vtu", SECONDVTU, TEN),
    PAIR("s1.ele", "1 10 1\n1 1 2 3 4 10 8 5 6 9 7 5\n", AS_IS, NULL, "s1.node", TEN_NODE1,
         TEN " {region=5 10}"),
    PAIR("s2.ele", "1 10 0\n1 1 2 3 4 5 6 7 8 9\n", AS_IS, NULL, "s2.node", TEN_NODE1,
         "!tetrahedron 0: its number, 10 points and 0 regions expected here"),
    /* OFF */
    PLAIN("tetrahedron.off", "OFF\n4 4 6\n" OFF_PLACES OFF_FACES, TETRA),
    CHANGED("crlf.off", "OFF\n4 4 6\n" OFF_PLACES OFF_FACES, CRLF, TETRA),
    CHANGED("no-end.off", "OFF\n4 4 6\n" OFF_PLACES OFF_FACES, NO_END, TETRA),
    PLAIN("coloured.off", OFF_COLOURED, TETRA),
    PLAIN("any-name.txt", "# by hand\nOFF4 4 6\n" OFF_PLACES OFF_FACES, TETRA),
    PLAIN("bare.off", "4 4 0\n" OFF_PLACES OFF_FACES, TETRA),
    PLAIN("normals.off",
          "NOFF\n4 4 0\n0 0 0 0 0 1\n1 0 0 0 0 1\n0 1 0 0 0 1\n0 0 1 0 0 1\n" OFF_FACES, TETRA),
    PLAIN("cube.off", OFF_CUBE, "8 nodes 12 triangles 6 quads volume 1"),
    PLAIN("prism.off", OFF_PRISM, "10 nodes 16 triangles volume 2.5"),
    PLAIN("lines.off", "OFF\n4 2 0\n" OFF_PLACES "2 0 1\n2 1 2\n",
          "!lines.off: it holds 2 lines and no triangle, quad or cell"),
    PLAIN("points.off", "OFF\n4 0 0\n" OFF_PLACES, "!points.off: it holds no triangle, quad"),
    PLAIN("binary.off", "OFF BINARY\n", "!binary.off:1: binary OFF is not read: write it as ASCII"),
    PLAIN("four.off", "4OFF\n1 1 0\n0 0 0 1\n1 0\n", "!this kind of OFF is not read"),
    PLAIN("range.off", "OFF\n4 1 0\n" OFF_PLACES "3 0 1 4\n",
          "!range.off:7: face 0: 3 vertices, numbered from 0 to 3, expected here"),
    PLAIN("short.off", "OFF\n4 1 0\n" OFF_PLACES "4 0 1 2\n",
          "!short.off:7: face 0: 4 vertices, numbered from 0 to 3, expected here"),
    PLAIN("nan.off", "OFF\n4 1 0\n0 nan 0\n" OFF_PLACES "3 0 1 2\n",
          "!nan.off:3: node 0: its position is not finite"),
    PLAIN("absurd.off", "OFF\n60000000 60000000 0\n" OFF_PLACES OFF_FACES,
          "!60000000 vertices and 60000000 faces announced"),
    PLAIN("corners.off", "OFF\n4 1 0\n" OFF_PLACES "2000 0 1 2\n",
          "!face 0 of 1: the number of its vertices (1 to 1024)"),
    CUT_AT("cut.off", "OFF\n4 4 6\n" OFF_PLACES OFF_FACES, "3 0 1 3\n",
           "!face 2 of 4: the number of its vertices"),
    /* TetGen */
    PAIR("t1.node", NODE1, AS_IS, NULL, "t1.ele", ELE1, BODY_TET1),
    PAIR("t2.1.ele", ELE1, AS_IS, NULL, "t2.1.node", NODE1, BODY_TET1),
    PAIR("t3.node", NODE0, AS_IS, NULL, "t3.ele", ELE0, BODY),
    PAIR("t4.node", NODE0, CRLF, NULL, "t4.ele", ELE0, BODY),
    PAIR("t5.ele", ELE0, NO_END, NULL, "t5.node", NODE0, BODY),
    PAIR("T6.NODE", NODE0, AS_IS, NULL, "T6.ELE", ELE0, BODY),
    PAIR("gaps.node", "4 3\n5 0 0 0\n9 1 0 0\n700 0 1 0\n2 0 0 1\n", AS_IS, NULL, "gaps.ele",
         "1 4\n3 5 9 700 2\n", "4 nodes 4 triangles 1 tetrahedra volume 0.166667"),
    PAIR("regions.ele", "2 4 1\n1 0 1 2 3 0.5\n2 0 2 1 4 2\n", AS_IS, NULL, "regions.node", NODE0,
         BODY),
    PLAIN("alone.node", NODE0, "!alone.ele: cannot read it (No such file or directory)"),
    PAIR("wrong-base.ele", ELE1, AS_IS, NULL, "wrong-base.node", NODE0,
         "!wrong-base.ele:3: tetrahedron 1: there is no point number 5"),
    PAIR("flat.node", "3 2 0 0\n1 0 0\n2 1 0\n3 0 1\n", AS_IS, NULL, "flat.ele", "1 3 0\n1 1 2 3\n",
         "!flat.node:1: points of 2 dimensions"),
    PAIR("o3.ele", "1 20 0\n1 1 2 3 4 5 6 7 8 9 10\n", AS_IS, NULL, "o3.node", NODE0,
         "!elements of 20 nodes"),
    PAIR("cut.node", NODE0, CUT, "2 0 1 0\n", "cut.ele", ELE0,
         "!cut.node:1: 5 points announced, but"),
    PAIR("cut2.ele", ELE0, CUT, "1 0 2", "cut2.node", NODE0,
         "!tetrahedron 1: its number, 4 points"),
    PAIR("absurd.ele", "80000000 4 0\n0 0 1 2 3\n", AS_IS, NULL, "absurd.node", NODE0,
         "!80000000 tetrahedra announced, but"),
    PAIR("more.ele", ELE0 "2 0 1 2 3\n", AS_IS, NULL, "more.node", NODE0,
         "!more.ele:4: more than the 2 tetrahedra announced"),
    PAIR("none.ele", "0 4 0\n", AS_IS, NULL, "none.node", NODE0,
         "!none.ele: it holds no triangle, quad or cell of a volume, so there is no body in it"),
    PAIR("inf.node", "1 3 0 0\n0 0 inf 0\n", AS_IS, NULL, "inf.ele", ELE0,
         "!inf.node:2: node 0: its position is not finite"),
    PAIR("negative.node", "1 3 0 0\n-1 0 0 0\n", AS_IS, NULL, "negative.ele", ELE0,
         "!point 0: its number (0 or more)"),
    PAIR("words.node", "hello\n", AS_IS, NULL, "words.ele", ELE0,
         "!words.node:1: the numbers of points"),
    /* VTK, legacy */
    PLAIN("grid.vtk", VTKGRID, BODY_VTK),
    CHANGED("grid-crlf.vtk", VTKGRID, CRLF, BODY_VTK),
    CHANGED("grid-no-end.vtk", VTKGRID, NO_END, BODY_VTK),
    PLAIN("grid.obj", VTKGRID, BODY_VTK),
    PLAIN("grid5.vtk", GRID5 POINTS CELLS5, BODY " -triangles 1"),
    PLAIN("order.vtk", GRID3 CELLS3 POINTS, BODY " -triangles 1"),
    PLAIN("binary3.vtk", NULL, BODY_VTK),
    PLAIN("binary5.vtk", NULL, BODY " {region=7 4} {region=8 4} {region=9 3} -triangles 1"),
    PLAIN("binary-cut.vtk", NULL, "!binary-cut.vtk: byte "),
    PLAIN("binary-absurd.vtk", NULL, "!values of the points announced, but the rest of the file"),
    PLAIN("binary-nan.vtk", NULL, "!byte 102: node 0: its position is not finite"),
    PLAIN("binary-flag.vtk",
          "# vtk DataFile Version 3.0\nt\nBINARY\nDATASET UNSTRUCTURED_GRID\n" POINTS,
          "!values of the points announced, but the rest of the file is too short"),
    PLAIN("kinds.vtk",
          GRID3 POINTS
          "CELLS 4 24\n4 0 1 2 3\n8 0 1 2 3 0 1 2 3\n3 0 1 2\n5 0 1 2 3 4\nCELL_TYPES 4\n"
          "10\n12\n5\n14\n",
          "!kinds.vtk:11: a hexahedron that has no volume: correct its nodes"),
    PLAIN("surface.vtk", POLY POLYGONS, TETRA),
    PLAIN("surface5.vtk",
          VTK5 "DATASET POLYDATA\nPOINTS 4 float\n0 0 0 1 0 0 0 1 0 0 0 1\nPOLYGONS 5 12\nOFFSETS "
               "vtktypeint64\n0 3 6 9 12\nCONNECTIVITY vtktypeint64\n0 2 1 0 1 3 1 2 3 2 0 3\n",
          TETRA),
    PLAIN("parts.vtk",
          POLY "LINES 1 3\n2 0 1\n" POLYGONS
               "VERTICES 1 2\n1 3\nCELL_DATA 6\nFIELD f 1\npart%20no 1 6 "
               "int\n1 2 3 3 3 4\n",
          TETRA " {part no=1 1} {part no=2 2} {part no=3 4} {part no=4 3} -points 1 -lines 1"),
    PLAIN("quads.vtk", POLY "POLYGONS 1 5\n4 0 1 2 3\n", "4 nodes 2 triangles 1 quads"),
    PLAIN("faces.vtk", POLY "POLYGONS 2 9\n4 0 1 2 3\n3 0 1 2\n", "4 nodes 3 triangles"),
    PLAIN("pentagon.vtk", VTK3 "DATASET POLYDATA\n" POINTS "POLYGONS 2 10\n3 0 1 2\n5 0 1 2 3 4\n",
          "5 nodes 1 triangles -polygons and strips 1"),
    PLAIN("arrays.vtk",
          POLY POLYGONS
          "POINT_DATA 4\nSCALARS t float\nLOOKUP_TABLE mine\n1 2 3 nan\nLOOKUP_TABLE mine "
          "1\n0 0 0 1\nVECTORS v double\n1 2 3 1 2 3 1 2 3 1 2 3\n" META
          "FIELD f 2\ngroup:top%20side 1 4 int\n0 0 1 1\nwords 1 2 string\na\nb "
          "c\nCOLOR_SCALARS c 1\n.1 .2 .3 .4\nGLOBAL_IDS i vtkIdType\n1 2 3 4\n",
          TETRA " {top side 2}"),
    PLAIN("structured.vtk", VTK3 "DATASET STRUCTURED_POINTS\nDIMENSIONS 2 2 2\n",
          "!structured.vtk:4: a dataset of kind 'STRUCTURED_POINTS' is not read"),
    PLAIN("version.vtk", "# vtk DataFile Version 9\nt\nASCII\n",
          "!a VTK file of version 9 is not read"),
    PLAIN("mode.vtk", "# vtk DataFile Version 3.0\nt\nASKII\n", "!then ASCII or BINARY"),
    CUT_AT("cut-points.vtk", VTKGRID, "0 0 0 1", "!too short for them: it is damaged or cut off"),
    CUT_AT("cut-cells.vtk", VTKGRID, "4 0 1 2 3\n3 0", "!cells announced, but the rest"),
    CUT_AT("cut-types.vtk", VTKGRID, "2 1 4\n", "!no types of the cells in it"),
    CUT_AT("cut-data.vtk", VTKGRID, "int 1\n", "!LOOKUP_TABLE and its name expected here"),
    PLAIN("absurd.vtk", GRID3 "POINTS 2000000000 double\n0 0 0\n",
          "!6000000000 values of the points"),
    PLAIN("negative.vtk", GRID3 "POINTS -5 double\n0 0 0\n",
          "!negative.vtk:5: POINTS, their number"),
    PLAIN("nan.vtk", GRID3 "POINTS 1 float\n0 nan 0\nCELLS 1 2\n1 0\nCELL_TYPES 1\n1\n",
          "!node 0: its position is not finite"),
    PLAIN("range.vtk", GRID3 POINTS "CELLS 1 5\n4 0 1 2 5\nCELL_TYPES 1\n10\n",
          "!range.vtk:10: cell 0: there is no point 5: they are numbered from 0 to 4"),
    PLAIN("range2.vtk", GRID3 POINTS "CELLS 1 5\n4 0 1 2 -1\nCELL_TYPES 1\n10\n",
          "!cell 0: there is no point -1"),
    PLAIN("corners.vtk", GRID3 POINTS "CELLS 1 4\n3 0 1 2\nCELL_TYPES 1\n10\n",
          "!cell 0, of type 10 (tetrahedra), has 3 nodes: it must have 4"),
    PLAIN("size.vtk", GRID3 POINTS "CELLS 1 4\n4 0 1 2\nCELL_TYPES 1\n10\n",
          "!cell 0: the number of its nodes, at most 3 here"),
    PLAIN("words.vtk", GRID3 POINTS "CELLS 1 5\n4 0 1 2 3\nCELL_TYPES 1\nten\n",
          "!cell 0: its type"),
    PLAIN("extra.vtk", GRID3 POINTS "7\n", "!extra.vtk:9: '7' is not a keyword"),
    PLAIN("offsets.vtk",
          GRID5 POINTS
          "CELLS 3 8\nOFFSETS vtktypeint64\n0 4 3\nCONNECTIVITY vtktypeint64\n0 1 2 3 0 2 "
          "1 4\nCELL_TYPES 2\n10 10\n",
          "!cell 1: its offset, not less than 4"),
    PLAIN("hexahedra.vtk", GRID3 POINTS "CELLS 1 9\n8 0 1 2 3 0 1 2 3\nCELL_TYPES 1\n12\n",
          "!hexahedra.vtk:10: a hexahedron that has no volume"),
    PLAIN("lines.vtk", POLY "LINES 2 6\n2 0 1\n2 1 2\n",
          "!lines.vtk: it holds 2 lines and no triangle, quad or cell of a volume"),
    PLAIN("no-cells.vtk", GRID3 POINTS, "!no cells in it"),
    PLAIN("types.vtk", GRID3 POINTS "CELLS 1 5\n4 0 1 2 3\nCELL_TYPES 2\n10 10\n",
          "!2 types of 1 cells"),
    PLAIN("data.vtk",
          GRID3 POINTS CELLS3 "POINT_DATA 4\nSCALARS a int\nLOOKUP_TABLE default\n1 2 3 4\n",
          "!a: 4 values for 5 points"),
    /* VTK, XML */
    PLAIN("grid.vtu", VTU, BODY_VTU),
    CHANGED("grid-crlf.vtu", VTU, CRLF, BODY_VTU),
    CHANGED("grid-no-end.vtu", VTU, NO_END, BODY_VTU),
    PLAIN("any-xml.txt", "  \n" FILE_BEGIN PIECE XML_CELLS XML_POINTS FILE_END,
          BODY " -triangles 1"),
    CUT_AT("cut-points.vtu", VTU, "0 1 0\n0 0", "!the text ends before </VTKFile>"),
    CUT_AT("cut-tag.vtu", VTU, "Name=\"offs", "!the text ends before </VTKFile>"),
    CUT_AT("cut-end.vtu", VTU, "</UnstructuredGrid>", "!the text ends before </VTKFile>"),
    PLAIN("binary.vtu",
          XML FILE_BEGIN PIECE "<Points><DataArray type=\"Float64\" NumberOfComponents=\"3\" "
                               "format=\"binary\">AAAA</DataArray></Points>" FILE_END,
          "!binary.vtu:7: arrays of format 'binary' are not read: write the file with data mode "
          "ASCII"),
    PLAIN("appended.vtu",
          XML FILE_BEGIN PIECE "<Points><DataArray type=\"Float64\" NumberOfComponents=\"3\" "
                               "format=\"appended\" offset=\"0\"/></Points>" FILE_END,
          "!arrays of format 'appended' are not read"),
    PLAIN("poly.vtu", XML "<VTKFile type=\"PolyData\">\n</VTKFile>\n",
          "!poly.vtu:3: a VTK file of type 'PolyData' is not read"),
    PLAIN("doctype.vtu", "<?xml version=\"1.0\"?><!DOCTYPE a [<!ENTITY b \"c\">]><VTKFile/>",
          "!declarations are not read"),
    PLAIN("pieces.vtu",
          XML FILE_BEGIN PIECE XML_POINTS XML_CELLS "</Piece>" PIECE XML_POINTS XML_CELLS FILE_END,
          "!a second piece"),
    PLAIN("absurd.vtu",
          XML FILE_BEGIN "<Piece NumberOfPoints=\"900000000\" NumberOfCells=\"1\">" FILE_END,
          "!more than 67 million points or cells"),
    PLAIN("absurd2.vtu",
          XML FILE_BEGIN "<Piece NumberOfPoints=\"1\" NumberOfCells=\"60000000\">" FILE_END,
          "!120000000 values of the cells announced"),
    PLAIN("negative.vtu",
          XML FILE_BEGIN "<Piece NumberOfPoints=\"-9\" NumberOfCells=\"1\">" FILE_END,
          "!a piece without good NumberOfPoints"),
    PLAIN("few.vtu",
          XML FILE_BEGIN
          "<Piece NumberOfPoints=\"6\" NumberOfCells=\"3\">" XML_POINTS XML_CELLS FILE_END,
          "!point 5 of 6: its x y z expected here"),
    PLAIN("many.vtu",
          XML FILE_BEGIN
          "<Piece NumberOfPoints=\"4\" NumberOfCells=\"3\">" XML_POINTS XML_CELLS FILE_END,
          "!more values of the points than there should be"),
    PLAIN("no-cells.vtu", XML FILE_BEGIN PIECE XML_POINTS FILE_END, "!no piece with connectivity"),
    PLAIN("no-piece.vtu", XML FILE_BEGIN "</UnstructuredGrid></VTKFile>",
          "!no piece with connectivity"),
};

/* ---- binary files ---- */

typedef struct builder {
    char data[2048];
    size_t size;
} builder;

static inline void put_text(builder *b, const char *text)
{
    memcpy(b->data + b->size, text, strlen(text));
    b->size += strlen(text);
}

static inline void put_integers(builder *b, int bytes, int count, const int64_t *value)
{
    for (int i = 0; i < count; ++i) {
        for (int k = bytes - 1; k >= 0; --k) {
            b->data[b->size++] = (char)(value[i] >> (8 * k));
        }
    }
    put_text(b, "\n");
}

static inline void put_doubles(builder *b, int count, const double *value)
{
    for (int i = 0; i < count; ++i) {
        uint64_t bits;
        memcpy(&bits, &value[i], sizeof bits);
        for (int k = 7; k >= 0; --k) {
            b->data[b->size++] = (char)(bits >> (8 * k));
        }
    }
    put_text(b, "\n");
}

/* The body of the other VTK files; what the name says is wrong with it. */
static inline void make_binary(const char *name, builder *b)
{
    double points[15] = {0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, -1};
    const bool is_new = strcmp(name, "binary5.vtk") == 0;
    if (strcmp(name, "binary-nan.vtk") == 0) {
        const uint64_t bits = UINT64_C(0x7ff8000000000000);
        memcpy(&points[1], &bits, sizeof bits);
    }
    b->size = 0;
    put_text(b, is_new ? "# vtk DataFile Version 5.1\nt\nBINARY\n"
                       : "# vtk DataFile Version 4.2\nt\nBINARY\n");
    put_text(b, "DATASET UNSTRUCTURED_GRID\nPOINTS ");
    put_text(b, strcmp(name, "binary-absurd.vtk") == 0 ? "70000000" : "5");
    put_text(b, " double\n");
    put_doubles(b, 15, points);
    if (is_new) {
        put_text(b, "CELLS 4 11\nOFFSETS vtktypeint64\n");
        put_integers(b, 8, 4, (const int64_t[]){0, 4, 7, 11});
        put_text(b, "CONNECTIVITY vtktypeint64\n");
        put_integers(b, 8, 11, (const int64_t[]){0, 1, 2, 3, 0, 1, 2, 0, 2, 1, 4});
    } else {
        put_text(b, "CELLS 3 14\n");
        put_integers(b, 4, 14, (const int64_t[]){4, 0, 1, 2, 3, 3, 0, 1, 2, 4, 0, 2, 1, 4});
    }
    put_text(b, "CELL_TYPES 3\n");
    put_integers(b, 4, 3, (const int64_t[]){10, 5, 10});
    put_text(b, "CELL_DATA 3\nSCALARS region short\nLOOKUP_TABLE default\n");
    put_integers(b, 2, 3, (const int64_t[]){7, 9, 8});
    b->size -= strcmp(name, "binary-cut.vtk") == 0 ? 40 : 0;
}

/* ---- loading ---- */

/* The file's bytes, with what its case changes. */
static inline size_t make_bytes(const file_case *c, char *out, size_t room)
{
    if (c->text == NULL) {
        builder b;
        make_binary(c->name, &b);
        assert_true(b.size <= room);
        memcpy(out, b.data, b.size);
        return b.size;
    }
    size_t length = strlen(c->text);
    if (c->change == CUT) {
        const char *place = strstr(c->text, c->cut);
        assert_non_null(place);
        length = (size_t)(place - c->text) + strlen(c->cut);
    }
    length -= c->change == NO_END;
    size_t size = 0;
    for (size_t i = 0; i < length; ++i) {
        if (c->change == CRLF && c->text[i] == '\n') {
            out[size++] = '\r';
        }
        out[size++] = c->text[i];
        assert_true(size + 1 < room);
    }
    return size;
}

/* A mesh in words. */
static inline void summarise(const ss_mesh *m, char *out, size_t size)
{
    ss_mesh_report r;
    assert_int_equal(ss_mesh_check(m, &r), SOFTSIM_OK);
    int used = snprintf(out, size, "%d nodes %d triangles", m->node_count, m->triangle_count);
    if (m->quad_count > 0) {
        used += snprintf(out + used, size - (size_t)used, " %d quads", m->quad_count);
    }
    if (m->tetrahedron_count > 0) {
        used += snprintf(out + used, size - (size_t)used, " %d tetrahedra", m->tetrahedron_count);
    }
    if (m->is_closed) {
        used += snprintf(out + used, size - (size_t)used, " volume %.6g", r.volume);
    }
    for (int32_t g = 0; g < m->group_count; ++g) {
        used += snprintf(out + used, size - (size_t)used, " {%s %d}", m->group[g].name,
                         m->group[g].node_count);
    }
    for (int k = 0; k < SS_MESH_KIND_COUNT; ++k) {
        if (m->skipped[k] > 0) {
            used += snprintf(out + used, size - (size_t)used, " -%s %lld",
                             ss_mesh_kind_name((ss_mesh_kind)k), (long long)m->skipped[k]);
        }
        if (m->split[k] > 0) {
            used += snprintf(out + used, size - (size_t)used, " /%s %lld",
                             ss_mesh_kind_name((ss_mesh_kind)k), (long long)m->split[k]);
        }
    }
}
