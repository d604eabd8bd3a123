"""The window that shows a cloth, in usdview's own Qt."""

from __future__ import annotations

from typing import Any

from pxr.Usdviewq.qt import QtCore, QtGui, QtWidgets

from weaveusd.usdview.card import ClothCard, card_html, card_text
from weaveusd.usdview.drawing import Drawing


def show_card(card: ClothCard, drawing: Drawing, parent: Any) -> Any:
    """Open a window beside `parent` with the draft on the left and the text on the right."""
    window = QtWidgets.QDialog(parent)
    window.setAttribute(QtCore.Qt.WA_DeleteOnClose)
    window.setWindowTitle(f"Cloth: {card.title}")
    sides = QtWidgets.QSplitter()
    sides.addWidget(_picture(drawing))
    text = QtWidgets.QTextBrowser()
    text.setHtml(card_html(card))
    sides.addWidget(text)
    copy = QtWidgets.QPushButton("Copy as text")
    copy.clicked.connect(lambda: QtWidgets.QApplication.clipboard().setText(card_text(card)))
    layout = QtWidgets.QVBoxLayout(window)
    layout.addWidget(sides)
    layout.addWidget(copy)
    window.resize(1200, 720)
    window.show()
    return window


def _picture(drawing: Drawing) -> Any:
    """Return a scrolled label with the picture, or with the reason why there is none."""
    label = QtWidgets.QLabel()
    label.setTextFormat(QtCore.Qt.PlainText)
    label.setAlignment(QtCore.Qt.AlignTop)
    label.setWordWrap(True)
    label.setText(drawing.reason)
    if drawing.pixels:
        image = QtGui.QImage(
            drawing.pixels,
            drawing.width,
            drawing.height,
            3 * drawing.width,
            QtGui.QImage.Format_RGB888,
        )
        # A pixmap copies; the image borrows the bytes.
        label.setPixmap(QtGui.QPixmap.fromImage(image))
    area = QtWidgets.QScrollArea()
    area.setWidget(label)
    area.setWidgetResizable(True)
    return area
