"""What every file of this study says of itself, as netCDF readers name it. `CITATION.cff` and `LICENSE` say more."""

ATTRIBUTES = {
    "title": "bipedstudy: a reproducible study of a passive biped walker",
    "license": "BSD-3-Clause",
    "references": (
        "Vasileiou, Smyrli, Drogosis, Papadopoulos: Development of a passive biped robot digital twin using analysis, "
        "experiments, and a multibody simulation environment. Mechanism and Machine Theory, 2021"
    ),
}

